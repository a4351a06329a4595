"""Detect rows that are probably not valid data, and reject or report them.

Summary rows and participants with two spellings of their label are rejected, because the number of
participants would be wrong. Labels that differ only in case, answers that were pasted twice or
copied from another participant, and usual codes for missing answers are reported.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    import pandas as pd

#: Labels of summary rows, except two-letter labels, which may be initials.
SUMMARIES = re.compile(
    r"(grand |geometric )?(mean|average|avg|median|total|sum|mittel(wert)?|moyenne|media|promedio)"
    r"|st(andar)?d\.? ?dev(iation)?\.?|stdev|streuung|standardabweichung|écart[- ]type",
    re.IGNORECASE,
)
#: Label with a whole number at its end, such as 01, 1.0, s01 or sub-01: text, number.
WHOLE_NUMBER = re.compile(r"(\D*?)0*(\d+)(?:[.,]0*)?")
#: Codes for missing answers in questionnaires and statistics programs.
MISSING_CODES = (99.0, 999.0, 9999.0, 99999.0, 88.0, 888.0, 77.0, 777.0)
#: Codes for missing answers are reported if they exceed this multiple of the largest other answer.
FAR = 3.0
#: Codes among the levels are refused if they exceed this multiple of the largest other level.
MUCH_FARTHER = 20.0
#: Minimum number of answers, and of different values, for reporting identical sequences.
FEWEST_ALIKE, FEWEST_VALUES = 8, 4


def check_labels(labels: Sequence[str], column: str, file: str) -> list[str]:
    """Check participant labels; return notes on suspicious ones.

    Labels such as 1 and 01 are rejected. Labels such as s1 and s01, or p1 and P1, are two people,
    with a note.

    Parameters
    ----------
    labels : sequence of str
        All distinct labels.
    column, file : str
        Column and file names to use in messages.

    Raises
    ------
    UserError
        If a label is typical of summary rows, or if two labels represent the same number.
    """
    summaries = [label for label in labels if SUMMARIES.fullmatch(label)]
    if summaries:
        raise UserError(
            "{file}, column {column}: '{example}' is probably a summary row and not a "
            "participant; remove the row, or rename the participant",
            file=file,
            column=column,
            example=summaries[0],
        )
    numbers: dict[tuple[str, str], str] = {}
    notes = []
    for label in labels:
        if found := WHOLE_NUMBER.fullmatch(label):
            first = numbers.setdefault((found[1], found[2]), label)
            if first != label and found[1]:
                notes.append(
                    f"{file}, column {column}: '{first}' and '{label}' have the same number and "
                    "are analysed as two participants"
                )
            elif first != label:
                raise UserError(
                    "{file}, column {column}: '{first}' and '{label}' represent the same "
                    "number; write the label of each participant in the same way in all rows and "
                    "files",
                    file=file,
                    column=column,
                    first=first,
                    label=label,
                )
    lower: dict[str, str] = {}
    return notes + [
        f"{file}, column {column}: '{lower[label.lower()]}' and '{label}' differ only in case and "
        "are analysed as two participants"
        for label in labels
        if lower.setdefault(label.lower(), label) != label
    ]


def check_levels(levels: pd.Series[float], file: str) -> None:
    """Raise `UserError` if a level is probably a code for a missing value.

    One level far from all others would decide where the levels lie, and with it the analysis. So
    would a code such as -99 that is the only level below 0.
    """
    sizes = levels.dropna().abs()
    codes = sizes.isin(MISSING_CODES)
    largest = sizes[~codes].max()
    for code in sorted(set(levels.dropna()[codes])):
        alone = code < 0 <= levels[~levels.isin([code])].min()
        if abs(code) > MUCH_FARTHER * largest or alone:
            raise UserError(
                "{file}: the level {code:g} is probably a code for a missing value, because the "
                "other levels lie between {least:g} and {largest:g}; leave these cells empty, or "
                "remove the rows",
                file=file,
                code=code,
                least=levels.dropna()[~codes].min(),
                largest=levels.dropna()[~codes].max(),
            )


def notes_on_answers(
    frame: pd.DataFrame, participant: str, level: str, answer: str, file: str
) -> Iterator[str]:
    """Yield notes on answers that were probably copied, and on codes for missing answers.

    Parameters
    ----------
    frame : DataFrame
        One row per answer, in order of presentation, with the columns named by the parameters
        below. Levels and answers are numbers.
    participant, level, answer, file : str
    """
    values = frame[answer].dropna()
    others = values[~values.isin(MISSING_CODES)]
    for code in MISSING_CODES:
        count = int((values == code).sum())
        if count and len(others) and code > FAR * others.max():
            yield (
                f"{file}: {count} answers are {code:g}, and the next largest answer is "
                f"{others.max():g}; "
                f"if {code:g} means a missing answer, write n/a"
            )
    known: dict[tuple[tuple[float, float], ...], str] = {}
    for who, rows in frame.groupby(participant, observed=True, sort=False):
        own = tuple(zip(rows[level].tolist(), rows[answer].tolist(), strict=True))
        half = len(own) // 2
        if len(own) % 2 == 0 and _alike(own[:half]) and own[:half] == own[half:]:
            yield (
                f"{file}: the last {half} answers of {who} repeat the first {half}; check "
                "whether they were pasted twice"
            )
        if _alike(own) and known.setdefault(own, str(who)) != str(who):
            yield (
                f"{file}: {known[own]} and {who} have the same {len(own)} answers in the same "
                "order; check whether they were copied"
            )


def _alike(own: tuple[tuple[float, float], ...]) -> bool:
    """Return whether answers are numerous and varied enough that a chance match is unlikely."""
    return len(own) >= FEWEST_ALIKE and len({answer for _, answer in own}) >= FEWEST_VALUES
