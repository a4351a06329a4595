"""Recognise layouts of tables by their cells, and return the options that describe them.

To recognise another layout, write a function that returns its options, or none, and add it to
`LAYOUTS`. The first that returns options applies.
"""

from __future__ import annotations

import re
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cleaning import as_numbers

#: Options with their values, as keywords.
Given = dict[str, object]
#: Values of a column with the chosen item of a pair, besides the names of the items.
SIDES = ({"left", "right"}, {"1", "2"}, {"first", "second"})
#: Smallest number of levels, people or items in columns, and largest number of items and of kinds.
FEWEST, MOST_ITEMS, MOST_KINDS = 3, 50, 12
#: Largest number of columns of numbers with blank cells, of which pairs are compared.
MOST_GAPS = 8
#: Column name that ends with a number: text, number.
NUMBERED = re.compile(r"(\D*?)(\d+(?:[.,]\d+)?)")
#: Names of columns with the number of all answers.
ALL_ANSWERS = re.compile(r"(?i)n|n_?trials|trials(_per_level)?|total|size|n_?total")
APART = re.compile(r"(?i).*(dissim|distance|apart|differ).*")


def layout_of(frame: pd.DataFrame) -> Given:
    """Return the options for a table with an unusual layout; none for one answer per row."""
    if frame.empty:
        return {}
    return next((given for of in LAYOUTS if (given := of(frame))), {})


def _square(frame: pd.DataFrame) -> Given:
    """Return the content of a square table of items."""
    first, *items = frame.columns
    labels = frame[first].astype("str").fillna("")
    if not items or sorted(labels) != sorted(items):
        return {}
    cells = frame.set_index(labels)[items].loc[items]
    values = cells.apply(lambda column: as_numbers(column)[1]).to_numpy(float)
    if not np.array_equal(values, values.T, equal_nan=True):
        return {"matrix": "wins"}
    known = values.diagonal()[~np.isnan(values.diagonal())]  # often blank in dissimilarities
    if np.isnan(values).all():
        return {}
    alike = known.size > 0 and known.min() == np.nanmax(values)
    return {"matrix": "similarities" if alike else "dissimilarities"}


def _paired_rows(frame: pd.DataFrame) -> Given:
    """Return the options if a column of words differs between rows of levels and of answers."""
    gaps = [name for name in frame if frame[name].isna().any() and _numeric(frame[name])]
    if len(gaps) > MOST_GAPS:
        return {}
    for kind in (name for name in frame if not _numeric(frame[name])):
        if frame[kind].nunique() > MOST_KINDS:
            continue
        for level, answer in combinations(gaps, 2):
            of = [frame[kind][frame[name].notna()] for name in (level, answer)]
            together = (frame[level].notna() & frame[answer].notna()).any()
            if together or any(len(set(own)) != 1 or own.isna().any() for own in of):
                continue
            # The stimulus comes first.
            shown, said = sorted(of, key=lambda own: own.index[0])
            if shown.iloc[0] != said.iloc[0]:
                return {
                    "stimulus": str(level if shown is of[0] else answer),
                    "response": str(answer if shown is of[0] else level),
                    "rows_of": f"{kind}={shown.iloc[0]},{said.iloc[0]}",
                }
    return {}


def _pairs(frame: pd.DataFrame) -> Given:
    """Return the options if two columns contain items, and a third the chosen one or a rating."""
    texts = {name: frame[name].dropna().astype(str) for name in frame}
    items = {name: set(cells) for name, cells in texts.items()}
    of_items = [name for name in frame if not _numeric(frame[name])]
    for first, second in combinations(of_items, 2):
        both, all_items = items[first] & items[second], items[first] | items[second]
        if not (len(both) > len(all_items) / 2 and FEWEST <= len(all_items) <= MOST_ITEMS):
            continue
        pair: Given = {"first": str(first), "second": str(second)}
        for name in frame.columns.drop([first, second]):
            own = frame[name].astype(str)
            chosen = ((own == frame[first]) | (own == frame[second]))[frame[name].notna()]
            if (len(chosen) and chosen.all()) or {each.lower() for each in items[name]} in SIDES:
                return pair | {"chosen": str(name)}
            if APART.fullmatch(str(name)) and _numeric(frame[name]):
                return pair | {"dissimilarity": str(name)}
    return {}


def _people_in_columns(frame: pd.DataFrame) -> Given:
    """Return the options if the first column contains levels, and the others are numbered."""
    first, *people = frame.columns
    levels = as_numbers(frame[first])[1]
    below = levels.notna().cumsum() > 0  # lines above the first level belong to the header
    alike = {found[1] if (found := NUMBERED.fullmatch(str(name))) else None for name in people}
    enough = len(people) > 1 and int(below.sum()) >= FEWEST
    if not enough or None in alike or alike == {""} or len(alike) != 1 or (~below).sum() > 1:
        return {}
    if levels[below].duplicated().any() or not levels[below].notna().all():
        return {}
    if not all(_numeric(frame.loc[below, name]) for name in people):
        return {}
    above = frame.loc[~below, first]
    name = str(above.iloc[0] if len(above) else first)
    return {"people_in_columns": True, "stimulus": name}


def _wide(frame: pd.DataFrame) -> Given:
    """Return the options if columns have the same name except for the level at its end."""
    groups: dict[str, list[str]] = {}
    for name in map(str, frame.columns):
        found = NUMBERED.fullmatch(name)
        if found and _numeric(frame[name]):
            groups.setdefault(found[1], []).append(name)
    if list(map(str, frame.columns)) == _places(frame.shape[1]):
        return {}  # the names of columns without a header
    levels = max(groups.values(), key=len, default=[])
    numbers = [name.removeprefix(str(NUMBERED.fullmatch(name)[1])) for name in levels]  # type: ignore[index]
    # Questions are numbered 1, 2, 3.
    if len(levels) < FEWEST or numbers == _places(len(levels)):
        return {}
    counted = [name for name in map(str, frame.columns) if ALL_ANSWERS.fullmatch(name)]
    return {"levels": levels} | ({"n": counted[0]} if counted else {})


def _places(count: int) -> list[str]:
    return [str(place) for place in range(1, count + 1)]


def _numeric(cells: pd.Series[Any]) -> bool:
    text, numbers = as_numbers(cells)
    text = text.dropna()
    return bool(len(text)) and bool(numbers[text.index].notna().all())


LAYOUTS = (_square, _paired_rows, _pairs, _people_in_columns, _wide)
