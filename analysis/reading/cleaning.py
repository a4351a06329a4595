"""Convert raw rows into validated columns.

Numbers are parsed, answers become 1 and 0, and missing labels receive default values. Invalid cells
become missing and are reported with file and line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import TRUE, as_answers
from slipscale.analysis.reading.cells import FEW, FEW_SHARE, cell, places
from slipscale.analysis.reading.delimited import LISTED_PROBLEMS, NOT_AVAILABLE, Problems, Source
from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.analysis.reading.trial_tables import (
    BLOCK,
    DIFFERENCE,
    ESTIMATION,
    FACTOR,
    IDENTITY,
    SERIES,
    STEP_AMPLITUDES,
)
from slipscale.experiments.dataset.schema import MAIN, PARTICIPANT, PRACTICE, VOIDED
from slipscale.faults import UserError
from slipscale.stimuli.quantity import DIGITS, PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    from slipscale.analysis.reading.meaning.mapping import AnswerWords

PHASES = (MAIN, PRACTICE)
#: Block numbers are labels and may be words.
ESTIMATION_NUMBERS = tuple(name for name in ESTIMATION.numbers if name != BLOCK)
#: Columns that a usable trial must have.
NEEDED = (*ESTIMATION.required, *STEP_AMPLITUDES)
#: Larger numbers are treated as typing errors, because their squares would overflow.
LARGEST = 1e100
#: Largest share of answers that repeat a trial number: more of them are numbers that restart.
MOST_DOUBLED = 0.1


def clean_estimates(
    frame: pd.DataFrame,
    sources: Sequence[Source],
    problems: Problems,
    quantity: Quantity = PLATE_AMPLITUDE,
    factors: Sequence[str] = (),
) -> pd.DataFrame:
    """Parse the rows of a tidy table of magnitude estimates.

    Columns listed in ``factors`` are converted to labels, and `FACTOR` is prepended to their names.
    """
    clean = pd.DataFrame(
        {
            PARTICIPANT: tidied(frame[PARTICIPANT]),
            "session": labels(frame, "session", ""),
            "run": labels(frame, "run", "1"),
            "file": frame["file"],
            "line": frame["line"],
        }
    )
    for column in ESTIMATION.required:
        clean[column] = numbers(frame, column, sources, problems, minimum=0.0)
    clean["level"] = told_apart(clean["level"], quantity)
    for column in ESTIMATION_NUMBERS:
        clean[column] = _optional_numbers(frame, column, sources, problems, minimum=0.0)
    clean[BLOCK] = labels(frame, BLOCK, "")
    clean["phase"] = _phases(frame, problems)
    clean["flag"] = labels(frame, "flag", "")
    clean["texture"] = labels(frame, "texture", "")
    clean = clean.assign(**_conditions(frame, factors))
    return _without_doubles(clean, clean[BLOCK], sources, problems)


def _conditions(frame: pd.DataFrame, factors: Sequence[str]) -> dict[str, pd.Series[Any]]:
    return {FACTOR + name: labels(frame, name, "") for name in factors if name in frame}


def clean_differences(
    frame: pd.DataFrame,
    sources: Sequence[Source],
    problems: Problems,
    quantity: Quantity = PLATE_AMPLITUDE,
    *,
    words: AnswerWords | None = None,
    factors: Sequence[str] = (),
    minimum: float = 0.0,
) -> pd.DataFrame:
    """Return the steps of a descending difference task; ``difference_felt`` is 1, 0 or missing.

    ``words`` are the codes of the answers, or None if they were not declared. ``minimum`` is the
    smallest valid level. For ``factors``, see `clean_estimates`.
    """
    clean = pd.DataFrame({name: frame[name] for name in (*IDENTITY, "file", "line")})
    for column in STEP_AMPLITUDES:
        found = numbers(frame, column, sources, problems, minimum=minimum, lost="the step")
        clean[column] = told_apart(found, quantity)
    for column in DIFFERENCE.numbers:
        clean[column] = _optional_numbers(frame, column, sources, problems)
    clean["difference_felt"] = as_answers(frame, "difference_felt", sources, problems, words=words)
    clean["catch"] = _catches(frame, clean, problems)
    clean["verbal_report"] = labels(frame, "verbal_report", "")
    clean["phase"] = _phases(frame, problems)
    clean["flag"] = labels(frame, "flag", "")
    clean = clean.assign(**_conditions(frame, factors))
    return _without_doubles(clean, labels(frame, SERIES, ""), sources, problems)


def in_order(frame: pd.DataFrame, problems: Problems) -> pd.DataFrame:
    """Sort the rows of a table by participant, session, run, block and trial number.

    Blocks keep their order within a run. If a trial number is missing, rows keep their order.
    """
    trials = as_numbers(frame["trial"])[1] if "trial" in frame else pd.Series(np.nan, frame.index)
    missing = int(trials.isna().sum())
    if missing:
        if missing < len(frame):
            problems.add(
                f"{missing} of {len(frame)} rows have no trial number, so all trials are analysed "
                "in the order of the rows"
            )
        return frame
    *runs, block = (_ranks(labels(frame, name, "")) for name in (*IDENTITY, BLOCK))
    first = frame["line"].groupby([frame["file"], *runs, block]).transform("min")
    # The last key is the first to sort by.
    order = np.lexsort([trials, first, *runs[::-1]])
    return frame.iloc[order].reset_index(drop=True)


def _ranks(names: pd.Series[Any]) -> pd.Series[int]:
    known = sorted(names.cat.categories, key=numbers_first)
    return names.astype(str).map({str(name): place for place, name in enumerate(known)})


def told_apart(levels: pd.Series[float], quantity: Quantity) -> pd.Series[float]:
    """Round levels, so that floating-point errors do not create additional levels."""
    if quantity.decimals is not None:
        return levels.round(quantity.decimals)
    known = levels.dropna().unique()
    return levels.map({level: float(f"{level:.{DIGITS}g}") for level in known})


def numbers(
    frame: pd.DataFrame,
    column: str,
    sources: Sequence[Source],
    problems: Problems,
    *,
    minimum: float = -np.inf,
    lost: str = "the trial",
) -> pd.Series[float]:
    """Convert a column to numbers; invalid cells become missing and are reported.

    Parameters
    ----------
    minimum : float
        Smallest valid number. Numbers above `LARGEST` are also invalid.
    lost : str
        What is omitted because of an invalid cell, as named in messages.
    """
    raw, values = as_numbers(frame[column])
    text = values.isna() & raw.notna()
    if text.any():
        text[text] = ~raw[text].str.strip().isin(NOT_AVAILABLE)
    if column in NEEDED:
        _refuse_many(frame, column, text, sources, problems)
    outside = values.notna() & ~((values >= minimum) & (values <= LARGEST))
    if column in NEEDED and int((values < minimum).sum()) > FEW:
        raise _below(frame, column, sources, problems, values=values, minimum=minimum)
    for bad, expected in (
        (text, "a number"),
        (outside, f"a number of {minimum:g} or more (at most {LARGEST:g})"),
    ):
        shown = frame[bad].head(LISTED_PROBLEMS)
        problems.add_many(
            [
                f"{place}, column {problems.title(column)}: '{cell(value)}' instead of "
                f"{expected}{_hint(value)}; {lost} is omitted"
                for place, value in zip(places(shown, sources), shown[column], strict=True)
            ],
            f"column {problems.title(column)}",
            int(bad.sum()),
        )
    return values.mask(outside)


def as_numbers(raw: pd.Series[Any]) -> tuple[pd.Series[Any], pd.Series[float]]:
    """Return a column as text and as numbers; cells that are not numbers become NaN."""
    if pd.api.types.is_bool_dtype(raw) or not pd.api.types.is_numeric_dtype(raw):
        # TRUE is not a number. Whole numbers too large for a float are Python integers.
        raw = raw.astype("str")
        return raw, pd.to_numeric(raw, errors="coerce").astype(float)
    return raw, raw.astype(float)


def _refuse_many(
    frame: pd.DataFrame,
    column: str,
    wrong: pd.Series[bool],
    sources: Sequence[Source],
    problems: Problems,
) -> None:
    """Raise a `UserError` if many cells are not numbers.

    Cells without letters or digits (``-``, ``.``, ``?``) represent missing numbers and are not
    counted.
    """
    if not wrong.any():
        return
    cells = frame.loc[wrong, column].astype("str")
    cells = cells[cells.str.contains(r"\w", regex=True)]
    if len(cells) <= max(FEW, FEW_SHARE * len(frame)):
        return
    first = frame.loc[cells.index[:1]]
    raise UserError(
        "{place}, column {column}: '{value}' and {others} others of the {rows} cells are not "
        "numbers; expected numbers in the same format throughout the file, and n/a for missing "
        "values",
        place=places(first, sources)[0],
        column=problems.title(column),
        value=cell(first[column].iloc[0]),
        others=len(cells) - 1,
        rows=len(frame),
    )


def _below(
    frame: pd.DataFrame,
    column: str,
    sources: Sequence[Source],
    problems: Problems,
    *,
    values: pd.Series[float],
    minimum: float,
) -> UserError:
    """Return the error for a column with many numbers below the minimum.

    If they were left out, the means would be those of the other answers.
    """
    below = values < minimum
    return UserError(
        "{place}, column {column}: {count} of the {cells} numbers are below {minimum:g}, but "
        "estimates and levels are {minimum:g} or more; for answers on a scale with two sides, "
        "state numbers from the lower end of the scale (add the same number to every answer)",
        place=places(frame[below].head(1), sources)[0],
        column=problems.title(column),
        count=int(below.sum()),
        cells=int(values.notna().sum()),
        minimum=minimum,
    )


def _hint(value: object) -> str:
    text = str(value)
    if "," not in text:
        return ""
    return " without thousands separators" if "." in text else " with a decimal point"


def _optional_numbers(
    frame: pd.DataFrame,
    column: str,
    sources: Sequence[Source],
    problems: Problems,
    *,
    minimum: float = -np.inf,
) -> pd.Series[float] | float:
    """Convert a column to numbers with `numbers`, or return NaN if it is absent or empty."""
    if column not in frame or not frame[column].notna().any():
        return np.nan
    return numbers(frame, column, sources, problems, minimum=minimum, lost="the cell")


def _in_lower_case(answers: pd.Series[Any]) -> pd.Series[Any]:
    return answers.astype("object").map(lambda value: str(value).strip().lower())


def _catches(frame: pd.DataFrame, clean: pd.DataFrame, problems: Problems) -> pd.Series[bool]:
    """Identify catch steps by amplitude; report rows in which the column ``catch`` disagrees."""
    unchanged = clean["level_before"] == clean["level"]
    if "catch" in frame:
        marked = _in_lower_case(frame["catch"])
        for sentence, wrong in (
            (
                "catch steps change the amplitude and are analysed as ordinary steps",
                marked.isin(TRUE) & ~unchanged,
            ),
            (
                "steps without a change are analysed as catch steps, although not marked as such",
                ~marked.isin(TRUE) & unchanged,
            ),
        ):
            if wrong.any():
                problems.add(f"{int(wrong.sum())} {sentence}")
    return unchanged


def tidied(names: pd.Series[Any]) -> pd.Series[Any]:
    """Convert names to categories with normalised whitespace; blank names become missing."""
    if isinstance(names.dtype, pd.CategoricalDtype):
        found, known = names.cat.codes.to_numpy(), names.cat.categories.tolist()
    else:
        found, values = pd.factorize(names.to_numpy(object))
        known = values.tolist()
    plain = [" ".join(str(name).split()) for name in known]
    kept = sorted(set(plain) - {""})
    if kept == known and isinstance(names.dtype, pd.CategoricalDtype):
        return names
    places = {name: place for place, name in enumerate(kept)}
    # Missing cells have code -1, which selects the last entry.
    lookup = np.array([*(places.get(name, -1) for name in plain), -1])
    codes = pd.Categorical.from_codes(lookup[found], pd.Index(kept, dtype=str))
    return pd.Series(codes, index=names.index, name=names.name)


def labels(frame: pd.DataFrame, column: str, missing: str) -> pd.Series[Any]:
    """Convert a column of names to categories, replacing missing names by ``missing``."""
    if column not in frame:
        return pd.Series(pd.Categorical([missing] * len(frame)), index=frame.index)
    values = tidied(frame[column])
    if missing not in values.cat.categories:
        values = values.cat.add_categories(missing)
    return values.fillna(missing)


def _phases(frame: pd.DataFrame, problems: Problems) -> pd.Series[Any]:
    """Return "practice" or "main" for each row; other labels are reported and count as main."""
    values = labels(frame, "phase", MAIN)
    counts = values.value_counts()
    for name, count in counts[counts > 0].items():
        if str(name).lower() not in PHASES:
            problems.add(
                f"Phase '{cell(name)}': its {count} trials are analysed as main trials; only "
                "trials in the phase 'practice' are omitted."
            )
    lookup = np.array([str(name).lower() == PRACTICE for name in values.cat.categories], int)
    codes = lookup[values.cat.codes]
    return pd.Series(pd.Categorical.from_codes(codes, pd.Index(PHASES)), frame.index)


def _without_doubles(
    clean: pd.DataFrame, part: pd.Series[Any], sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Drop and report rows that repeat a trial within the same part of a run.

    ``part`` contains the block or series of each trial; trial numbers may restart in each part.
    """
    if clean["trial"].isna().all():
        return clean
    key = clean[[*IDENTITY, "phase", "trial"]].assign(part=part)
    duplicated = clean["trial"].notna() & key.duplicated(keep="first")
    duplicated &= (
        ~clean["flag"].astype(str).str.contains(VOIDED) if duplicated.any() else duplicated
    )
    if duplicated.sum() > MOST_DOUBLED * len(clean):
        raise UserError(
            "{doubled} of {count} answers repeat a trial number of the same person, so that they "
            "would be dropped; name the column in which the numbers restart (--block, or block), "
            "or leave --trial out",
            doubled=int(duplicated.sum()),
            count=len(clean),
        )
    shown = clean[duplicated].head(LISTED_PROBLEMS)
    problems.add_many(
        [
            f"{place}: trial {trial:g} of {who} occurs twice; only the first is kept"
            for place, trial, who in zip(
                places(shown, sources), shown["trial"], shown[PARTICIPANT], strict=True
            )
        ],
        "doubled trials",
        int(duplicated.sum()),
    )
    return clean[~duplicated].reset_index(drop=True) if duplicated.any() else clean


def empty_estimates() -> pd.DataFrame:
    """Return an empty table with the columns of `clean_estimates`."""
    return _empty(
        (*IDENTITY, BLOCK, "phase", "flag", "texture"),
        (*ESTIMATION_NUMBERS, *ESTIMATION.required),
    )


def empty_differences() -> pd.DataFrame:
    """Return an empty table with the columns of `clean_differences`."""
    found = _empty(
        (*IDENTITY, "phase", "flag", "verbal_report"), (*DIFFERENCE.numbers, *DIFFERENCE.required)
    )
    return found.assign(catch=np.array([], bool))


def _empty(text: Sequence[str], values: Sequence[str]) -> pd.DataFrame:
    columns: dict[str, Any] = {name: pd.Categorical([]) for name in text}
    return pd.DataFrame(columns | {name: np.array([], float) for name in (*values, "file", "line")})
