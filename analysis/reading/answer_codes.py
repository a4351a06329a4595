"""Identify which codes in an answer column mean yes.

Rules:

- Common pairs of codes, such as yes and no or 1 and 0, are recognised (`PAIRS`). For any other
  pair, the user must declare which code means yes; of the other codes, the most frequent means no.
- Cells that match neither code are excluded and reported. If more than `FEW` cells and more than
  the proportion `FEW_SHARE` of the filled cells match neither code, the column is probably not an
  answer column and is rejected.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cells import FEW, FEW_SHARE, cell, places
from slipscale.analysis.reading.delimited import LISTED_PROBLEMS, NOT_AVAILABLE, Problems, Source
from slipscale.faults import UserError

#: Codes in tables written by Slipscale.
TRUE, FALSE = frozenset({"yes", "true", "1", "1.0"}), frozenset({"no", "false", "0", "0.0"})
#: Pairs of codes that are recognised as yes and no, or right and wrong.
PAIRS = (
    (TRUE, FALSE),
    (frozenset({"y"}), frozenset({"n"})),
    (frozenset({"t"}), frozenset({"f"})),
    (frozenset({"ja", "j"}), frozenset({"nein", "n", "nee"})),
    (frozenset({"oui", "o"}), frozenset({"non", "n"})),
    (frozenset({"sí", "si", "s"}), frozenset({"no", "n"})),
    (frozenset({"correct", "right"}), frozenset({"incorrect", "wrong"})),
)
#: Maximum number of codes to list in a message.
LISTED = 8


def own_answers(cells: pd.Series[Any]) -> pd.Series[float]:
    """Convert answers in Slipscale's own tables to 1 (yes, true), 0 (no, false) or NaN."""
    codes = cells.astype("object").map(lambda value: str(value).strip().lower())
    return codes.map(dict.fromkeys(TRUE, 1.0) | dict.fromkeys(FALSE, 0.0))


def as_answers(
    frame: pd.DataFrame,
    column: str,
    sources: Sequence[Source],
    problems: Problems,
    *,
    yes: str | None = None,
) -> pd.Series[float]:
    """Convert a column of answers to 1 (yes), 0 (no) or NaN (missing).

    Parameters
    ----------
    frame : DataFrame
        Table that contains the answer column and the columns ``file`` and ``line``.
    column : str
        Name of the answer column.
    yes : str, optional
        Code that means yes; by default, common pairs such as yes/no or 1/0 are recognised.

    Raises
    ------
    UserError
        If the codes are not a common pair and `yes` is not given, if `yes` does not occur, or if
        too many cells match neither code.
    """
    codes = _codes(frame[column])
    counts = codes.value_counts()
    where = f"{sources[0].name}, column {problems.title(column)}" if sources else column
    agreed, disagreed = _meaning(counts, where, yes)
    found = codes.map(dict.fromkeys(agreed, 1.0) | dict.fromkeys(disagreed, 0.0)).astype(float)
    wrong = found.isna() & codes.notna()
    shown = frame[wrong].head(LISTED_PROBLEMS)
    problems.add_many(
        [
            f"{place}, column {problems.title(column)}: '{cell(value)}' instead of "
            f"{_listed(agreed)} or {_listed(disagreed)}; the trial is left out"
            for place, value in zip(places(shown, sources), shown[column], strict=True)
        ],
        f"column {problems.title(column)}",
        int(wrong.sum()),
    )
    return found


def _codes(cells: pd.Series[Any]) -> pd.Series[Any]:
    """Normalise cells for comparison: lower case, and whole numbers without decimals."""
    text = cells.astype("object").map(
        lambda value: (
            f"{value:g}"
            if isinstance(value, int | float) and not isinstance(value, bool)
            else str(value).strip().lower()
        )
    )
    missing = cells.isna() | text.isin({*(word.lower() for word in NOT_AVAILABLE), "", "nan"})
    return text.mask(missing, np.nan)


def _meaning(
    counts: pd.Series[int], where: str, yes: str | None
) -> tuple[frozenset[str], frozenset[str]]:
    """Return the codes that mean yes and the codes that mean no."""
    most_lost = max(FEW, FEW_SHARE * int(counts.sum()))
    if yes is not None:
        wanted = yes.strip().lower()
        if wanted not in counts.index:
            raise UserError(
                "{where}: '{yes}' does not occur; found {answers}. Set --yes to one of these codes",
                where=where,
                yes=yes,
                answers=_described(counts),
            )
        others = counts.drop(wanted)
        if len(others) and int(others.iloc[1:].sum()) > most_lost:
            raise UserError(
                "{where}: besides '{yes}' there are {others}; expected only two codes, for yes "
                "and no. Exclude the other rows (--only), or name another column",
                where=where,
                yes=yes,
                others=_described(others),
            )
        return frozenset({wanted}), frozenset(map(str, others.index[:1]))
    for agreed, disagreed in PAIRS:
        lost = counts[[code not in agreed | disagreed for code in counts.index]]
        if int(lost.sum()) <= most_lost and int(counts.sum() - lost.sum()) > 0:
            return agreed, disagreed
    raise UserError(
        "{where}: the answers are {answers}; expected yes and no. State which code means yes, "
        "for example --yes {code}; for counts of yes answers, use --yes-count and --n",
        where=where,
        answers=_described(counts),
        code=next(iter(counts.index), "CODE"),
    )


def _described(counts: pd.Series[int]) -> str:
    shown = [f"'{cell(code)}' ({number} times)" for code, number in counts.items()]
    more = f" and {len(shown) - LISTED} other codes" if len(shown) > LISTED else ""
    return (", ".join(shown[:LISTED]) + more) or "all missing"


def _listed(codes: frozenset[str]) -> str:
    return "/".join(sorted(codes, key=lambda code: (code[:1].isdigit(), code))) or "the other code"
