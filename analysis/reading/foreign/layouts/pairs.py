"""Convert ratings of pairs, and choices in pairs.

A choice is the name of the item, or its place: left or right, first or second, 1 or 2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.reading.answer_codes import codes_of, described, without_missing
from slipscale.analysis.reading.cleaning import labels, numbers, tidied
from slipscale.analysis.reading.foreign.layouts.layout import COMPARISONS, PAIRS, Rows
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

ITEMS = ("first", "second")
#: Codes for the place of the chosen item.
FIRST, SECOND = frozenset({"left", "first", "1", "l"}), frozenset({"right", "second", "2", "r"})


def _known(frame: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Return a table with labels of items, participant, session and run."""
    return frame.assign(
        **{name: labels(frame, name, "").astype(str) for name in names},
        **{name: labels(frame, name, missing) for name, missing in (("session", ""), ("run", "1"))},
        **{PARTICIPANT: tidied(frame[PARTICIPANT])},
        trial=range(1, len(frame) + 1),
        catch=False,
    )


def _whole(
    rows: Rows, frame: pd.DataFrame, needed: pd.Series[bool], names: Sequence[str]
) -> pd.DataFrame:
    whole = needed & (frame[list(names)] != "").all(axis=1)
    if not whole.all():
        rows.problems.add(f"{int((~whole).sum())} rows without an answer or an item are omitted")
    return frame[whole].reset_index(drop=True)


def rated(rows: Rows) -> Mapping[str, pd.DataFrame]:
    """Return the ratings of pairs of items."""
    frame = _known(rows.frame, ITEMS).assign(
        dissimilarity=numbers(rows.frame, "dissimilarity", rows.sources, rows.problems, minimum=0),
        task="similarity",
        sorted=False,
    )
    return {PAIRS: _whole(rows, frame, frame["dissimilarity"].notna(), ITEMS)}


def compared(
    rows: Rows,
    frame: pd.DataFrame,
    names: Sequence[str],
    response: NDArray[np.float64] | pd.Series[float],
) -> Mapping[str, pd.DataFrame]:
    """Return comparisons of two to four items, with 1 or 2 as the response."""
    frame = _known(frame, names).assign(task=COMPARISONS, response=response)
    frame = _whole(rows, frame, frame["response"].notna(), names)
    items = dict(zip(names, ("stimulus1", "stimulus2", "stimulus3", "stimulus4"), strict=False))
    blank = dict.fromkeys({"stimulus3", "stimulus4"} - set(items.values()), "")
    return {COMPARISONS: frame.rename(columns=items).assign(**blank)}


def convert(rows: Rows) -> Mapping[str, pd.DataFrame]:
    """Return the choices in pairs.

    Raises
    ------
    UserError
        If a choice is neither one of the items nor a place, or could be both.
    """
    if "chosen" not in rows.frame:
        return rated(rows)
    frame = without_missing(
        rows.frame, "chosen", rows.mapping.answers.missing, rows.problems
    ).reset_index(drop=True)
    chosen, (one, other) = codes_of(frame["chosen"]), (codes_of(frame[name]) for name in ITEMS)
    by_name = np.select([chosen == one, chosen == other], [1.0, 2.0], np.nan)
    by_place = np.select([chosen.isin(FIRST), chosen.isin(SECOND)], [1.0, 2.0], np.nan)
    found = [way for way in (by_name, by_place) if not np.isnan(way[chosen.notna()]).any()]
    if len(found) == 2 and not np.array_equal(found[0], found[1], equal_nan=True):  # noqa: PLR2004 - both
        raise UserError(
            "column {column}: 1 and 2 could be the names of the items or their places; rename the "
            "items, or write left and right",
            column=rows.problems.title("chosen"),
        )
    if not found:
        unknown = chosen[np.isnan(by_name) & np.isnan(by_place)].value_counts()
        if not len(unknown):
            unknown = chosen[np.isnan(by_name)].value_counts()
        raise UserError(
            "column {column}: {unknown} is neither an item of the same row nor left, right, first, "
            "second, 1 or 2; state codes without a choice with --missing CODE",
            column=rows.problems.title("chosen"),
            unknown=described(unknown),
        )
    return compared(rows, frame, ITEMS, found[0])
