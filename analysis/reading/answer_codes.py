"""Identify which codes in an answer column mean yes, and which mean no.

Rules:

- Common pairs of codes, such as yes and no or 1 and 0, are recognised (`PAIRS`) if no other code
  occurs. For any other coding, the user states which codes mean yes, which mean no, and which mean
  that there was no answer. If one code is left, it needs no statement.
- No code is left out because it is rare: 2 may mean wrong in 4 % of the trials, and 0 may mean
  late. A column that mixes codings, such as TRUE, FALSE and 0, is rejected with the counts.
- Answers with a code that means missing are excluded and counted.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import pandas as pd

from slipscale.analysis.reading.cells import cell
from slipscale.analysis.reading.delimited import NOT_AVAILABLE, Problems, Source
from slipscale.analysis.reading.programs.records import as_text
from slipscale.faults import UserError
from slipscale.faults.message import Message

if TYPE_CHECKING:
    from slipscale.analysis.reading.meaning.mapping import AnswerWords

#: Codes in tables written by Slipscale.
TRUE, FALSE = frozenset({"yes", "true", "1", "1.0"}), frozenset({"no", "false", "0", "0.0"})
#: Pairs of codes, yes (or right) before no (or wrong), that are recognised if only they occur.
PAIRS = (
    *(("yes", "no"), ("true", "false"), ("1", "0"), ("y", "n"), ("t", "f")),
    *(("ja", "nein"), ("ja", "nee"), ("j", "n")),
    *(("oui", "non"), ("o", "n")),
    *(("sí", "no"), ("si", "no"), ("s", "n")),
    *(("correct", "incorrect"), ("correct", "wrong"), ("right", "wrong")),
)
#: Whole number with decimals, as programs write a column with blank cells.
WHOLE = re.compile(r"^([+-]?\d+)\.0*$")
#: Maximum number of codes to list in a message.
LISTED = 8


def are_usual(codes: Sequence[str]) -> bool:
    """Return whether only the codes of a usual pair occur, so that their meaning is known."""
    found = set(map(_code, codes))
    return any(found <= set(pair) for pair in PAIRS)


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
    words: AnswerWords | None = None,
) -> pd.Series[float]:
    """Convert a column of answers to 1 (yes), 0 (no) or NaN (missing).

    Parameters
    ----------
    frame : DataFrame
        Table that contains the answer column and the columns ``file`` and ``line``.
    column : str
        Name of the answer column.
    words : AnswerWords, optional
        Codes that mean yes, no and missing; by default, common pairs such as yes/no or 1/0 are
        recognised.

    Raises
    ------
    UserError
        If the meaning of a code is neither known nor stated, or if no stated code for yes occurs.
    """
    codes = codes_of(frame[column])
    title = problems.title(column)
    where = (
        Message("{file}, column {column}", file=sources[0].name, column=title)
        if sources
        else column
    )
    yes, no = (_stated(words.yes), _stated(words.no)) if words else (frozenset(), frozenset())
    agreed, disagreed = _meaning(codes.value_counts(), where, yes, no)
    return codes.map(dict.fromkeys(agreed, 1.0) | dict.fromkeys(disagreed, 0.0)).astype(float)


def without_missing(
    frame: pd.DataFrame, column: str, missing: Sequence[str] | None, problems: Problems
) -> pd.DataFrame:
    """Leave out the rows whose code means that there is no answer, and report their number."""
    codes = codes_of(frame[column])
    left_out = codes.isin(_stated(missing))
    if not left_out.any():
        return frame
    problems.add(
        f"column {problems.title(column)}: {int(left_out.sum())} of {len(frame)} trials are left "
        f"out, because {described(codes[left_out].value_counts())} means that there is no answer"
    )
    return frame[~left_out].reset_index(drop=True)


def _stated(codes: Sequence[str] | None) -> frozenset[str]:
    return frozenset(map(_code, codes or ()))


def _code(text: str) -> str:
    return WHOLE.sub(r"\1", text.strip().lower())


def codes_of(cells: pd.Series[Any]) -> pd.Series[Any]:
    """Normalise cells for comparison: lower case, and whole numbers without decimals."""
    missing = {*(word.lower() for word in NOT_AVAILABLE), "nan"}
    codes = {value: _code(as_text(value) or "") for value in cells.dropna().unique()}
    return cells.map({value: code for value, code in codes.items() if code not in missing})


def _meaning(
    counts: pd.Series[int], where: str, yes: frozenset[str], no: frozenset[str]
) -> tuple[frozenset[str], frozenset[str]]:
    """Return the codes that mean yes and the codes that mean no."""
    found = frozenset(map(str, counts.index))
    if yes and not yes & found:
        raise UserError(
            "{where}: '{yes}' does not occur; found {answers}. Set --yes to one of these codes",
            where=where,
            yes=", ".join(sorted(yes)),
            answers=described(counts),
        )
    if not (yes or no):
        for agreed, disagreed in PAIRS:
            if found and found <= {agreed, disagreed}:
                return frozenset({agreed}), frozenset({disagreed})
        raise UserError(
            "{where}: the answers are {answers}; expected one code for yes and one for no. State "
            "what the codes mean, for example --yes {code}, and, with more than two codes, --no "
            "CODE for no or wrong and --missing CODE for no answer; for counts of yes answers, use "
            "--yes-count and --n",
            where=where,
            answers=described(counts),
            code=shlex.quote(_like_yes(counts)),
        )
    others = found - yes - no
    if others and (len(others) > 1 or (yes and no)):
        raise UserError(
            "{where}: the meaning of {others} is not stated; expected --no CODE for no or wrong, "
            "or --missing CODE for no answer (or exclude the rows with --only)",
            where=where,
            others=described(counts[counts.index.isin(others)]),
        )
    return (yes, no | others) if yes else (others, no)


def _like_yes(counts: pd.Series[int]) -> str:
    """Return the code that usually means yes, otherwise the most frequent one, as an example."""
    usual = [agreed for agreed, _ in PAIRS if agreed in counts.index]
    return str(next(iter([*usual, *counts.index]), "CODE"))


def described(counts: pd.Series[int]) -> str:
    """List codes with their numbers, for messages."""
    shown = [f"'{cell(code)}' ({number} times)" for code, number in counts.items()]
    first, more = ", ".join(shown[:LISTED]), len(shown) - LISTED
    if more > 0:
        return Message("{first} and {more} other codes", first=first, more=more)
    return first or "all missing"
