"""Cells that ought to be numbers, made numbers; every one that is none is named by its place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from analysis.reading.delimited import LISTED_PROBLEMS, NOT_AVAILABLE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.reading.delimited import Problems, Source

#: Characters of a cell in a message.
LONGEST_CELL = 60
#: A number above this is a slip, and its square no longer one.
LARGEST = 1e100


def places(rows: pd.DataFrame, sources: Sequence[Source]) -> list[str]:
    """Return "file, line n" for each row."""
    pairs = zip(rows["file"].tolist(), rows["line"].tolist(), strict=True)
    return [f"{sources[int(number)].name}, line {line}" for number, line in pairs]


def numbers(
    frame: pd.DataFrame,
    column: str,
    sources: Sequence[Source],
    problems: Problems,
    *,
    minimum: float = -np.inf,
    lost: str = "the trial",
) -> pd.Series[float]:
    """Return a column as numbers; what is not one becomes missing and is named in ``problems``.

    Parameters
    ----------
    minimum : float
        Smaller values, and those above `LARGEST`, are named and become missing too.
    lost : str
        What is left out where the cell cannot be read.
    """
    raw = frame[column]
    if pd.api.types.is_bool_dtype(raw) or not pd.api.types.is_numeric_dtype(raw):
        raw = raw.astype("str")  # TRUE is no number
        values = pd.to_numeric(raw, errors="coerce").astype(float)
    else:
        values = raw.astype(float)
    text = values.isna() & raw.notna()
    if text.any():
        text[text] = ~raw[text].str.strip().isin(NOT_AVAILABLE)
    outside = values.notna() & ~((values >= minimum) & (values <= LARGEST))
    for bad, expected in (
        (text, "a number"),
        (outside, f"a number of {minimum:g} or more, at most {LARGEST:g},"),
    ):
        shown = frame[bad].head(LISTED_PROBLEMS)
        problems.add_many(
            [
                f"{place}, column {column}: '{cell(value)}' where {expected}{_hint(value)} was "
                f"expected; {lost} is left out"
                for place, value in zip(places(shown, sources), shown[column], strict=True)
            ],
            f"column {column}",
            int(bad.sum()),
        )
    return values.mask(outside)


def cell(value: object) -> str:
    r"""Return a cell for a message: on one line, and not too long.

    >>> cell("five\nor six")
    'five or six'
    """
    text = " ".join(str(value).split())
    return text if len(text) <= LONGEST_CELL else f"{text[:LONGEST_CELL]} ..."


def _hint(value: object) -> str:
    text = str(value)
    if "," not in text:
        return ""
    return " without marks between thousands" if "." in text else " with a decimal point"
