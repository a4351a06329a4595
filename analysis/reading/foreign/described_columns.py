"""Describe the columns of a table, and find those that could contain the levels."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from slipscale.analysis.reading.cells import cell
from slipscale.analysis.reading.cleaning import as_numbers

#: Largest number of values that are listed, and of levels.
LISTED, MOST_LEVELS = 8, 30
#: Smallest number of levels, and of numbers that are rather those of trials.
FEWEST_LEVELS, FEWEST_COUNTED = 3, 13
#: Names of columns that count trials or contain times.
NO_LEVELS = re.compile(
    r"(?i)this(rep|trial)?n$|(^|[._ ])(rt|time|index|trial|block|run|session|age)|time$|_nr$"
)
#: Names of columns that contain levels, even of many different ones.
LEVELS = re.compile(
    r"(?i)level|stim|intens|amplitude|contrast|offset|coheren|pressure|frequency|(^|[._ ])db$"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Description of a column.

    Parameters
    ----------
    name : str
    values : tuple of str
        Its most frequent values, at most `LISTED`; numbers in ascending order.
    distinct, missing : int
        Number of different values, and of blank cells.
    range : tuple of float or None
        Smallest and largest number; None if the values are not numbers.
    """

    name: str
    values: tuple[str, ...]
    distinct: int
    missing: int
    range: tuple[float, float] | None

    @property
    def like_levels(self) -> bool:
        """Whether the column could contain the levels."""
        few = self.range is not None and FEWEST_LEVELS <= self.distinct <= MOST_LEVELS
        return few and not NO_LEVELS.search(self.name)

    def __str__(self) -> str:
        """Return the description in one line."""
        kind = "text" if self.range is None else f"{self.range[0]:g} to {self.range[1]:g}"
        more = ", ..." if self.distinct > len(self.values) else ""
        blank = f"; {self.missing} missing" if self.missing else ""
        count = "1 value" if self.distinct == 1 else f"{self.distinct} values"
        return f"{cell(self.name)}: {kind}, {count} ({', '.join(self.values)}{more}){blank}"


def describe(frame: pd.DataFrame) -> tuple[Column, ...]:
    """Describe the columns that contain any value."""
    return tuple(_column(str(name), frame[name]) for name in frame if frame[name].notna().any())


def _column(name: str, cells: pd.Series[Any]) -> Column:
    text, numbers = as_numbers(cells)
    text = text.dropna()
    whole = bool(len(text)) and bool(numbers[text.index].notna().all())
    counts = (numbers if whole else text).value_counts()
    shown = sorted(counts.index[:LISTED]) if whole else counts.index[:LISTED]
    return Column(
        name=name,
        values=tuple(f"{value:g}" if whole else cell(value) for value in shown),
        distinct=len(counts),
        missing=len(cells) - len(text),
        range=(float(numbers.min()), float(numbers.max())) if whole else None,
    )


def levels_in(
    frame: pd.DataFrame, people: Sequence[str], free: Sequence[Column]
) -> tuple[list[Column], bool]:
    """Return the columns that could contain the levels, and whether they are likely to.

    Levels vary within people; scores of a questionnaire do not. Numbers that count the rows of each
    person (trials, phases) are candidates only if there are no others. Columns with many values are
    likely to contain levels only if they are named like them.
    """
    who = frame[people[0]].astype("str") if people else pd.Series("", frame.index)
    varied = [
        column
        for column in free
        if column.range is not None and column.distinct >= FEWEST_LEVELS
        if not NO_LEVELS.search(column.name)
        if _varies(frame[column.name], who)
    ]
    named = [column for column in varied if LEVELS.search(column.name)]
    likely = [column for column in varied if column.like_levels or column in named]
    apart = [c for c in likely if c in named or not _counts(frame[c.name], who)]
    if apart:
        return apart, True
    return likely or varied, False


def _varies(cells: pd.Series[Any], who: pd.Series[str]) -> bool:
    """Return whether a column has several values for any person."""
    return bool((cells.groupby(who).nunique().to_numpy() > 1).any())


def _counts(cells: pd.Series[Any], who: pd.Series[str]) -> bool:
    """Return whether many whole numbers rise in steps of 0 or 1 within each person's rows.

    Few of them may be levels in ascending order.
    """
    numbers = as_numbers(cells)[1]
    steps = numbers.groupby(who).diff().dropna()
    return numbers.nunique() >= FEWEST_COUNTED and bool(steps.isin([0, 1]).all())
