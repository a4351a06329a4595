"""Convert estimates and answers, one per row or counted, to Slipscale's format."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import without_missing
from slipscale.analysis.reading.cleaning import (
    LARGEST,
    clean_differences,
    clean_estimates,
    in_order,
    labels,
    numbers,
    tidied,
    told_apart,
)
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.reading.foreign.columns import (
    ANSWER,
    REFERENCE,
    RESPONSE,
    STIMULUS,
)
from slipscale.analysis.reading.foreign.layouts.counts import one_row_per_answer
from slipscale.analysis.reading.foreign.layouts.layout import (
    CHOICES,
    DIFFERENCES,
    ESTIMATES,
    Rows,
)
from slipscale.analysis.reading.meaning.units import column_name
from slipscale.analysis.reading.table_lines import listed_lines
from slipscale.analysis.reading.trial_tables import BLOCK, FACTOR, IDENTITY, SERIES
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.meaning.mapping import TableMapping
    from slipscale.stimuli.quantity import Quantity

#: Units and names of logarithmic quantities, such as dB, dBA and level_db, but not dbl.
LOGARITHMIC = re.compile(r"(?<![A-Za-z])(dB[A-Z]?\w{0,2}|db|DB)(?![A-Za-z])|(?i:decibel|\blog)")
#: Label of the task in a table of answers.
ANSWERS = "answers"
#: Maximum number of standards, because one function is fitted per standard.
MOST_STANDARDS = 12
#: Largest share of answers without a level or a standard, which are left out.
MOST_WITHOUT = 0.5
#: Number of answers at the smallest level, and proportion of "yes" that suggests guessing.
FEWEST_TO_WARN, LIKE_GUESSING = 10, 1 / 3


def convert_trials(rows: Rows) -> Mapping[str, pd.DataFrame]:
    """Return magnitude estimates, yes-no differences, forced choices or comparisons.

    Raises
    ------
    UserError
        If there are too many standards, or levels are below 0 where they must not be.
    """
    mapping, problems = rows.mapping, rows.problems
    answered = RESPONSE not in rows.frame
    frame = _of_trials(rows)
    # Labels become categories once, so that later steps compare numbers instead of texts.
    names = [name for name in (*IDENTITY, BLOCK, "factor") if name in frame]
    frame = frame.assign(**{name: tidied(frame[name]) for name in names})
    for name in (PARTICIPANT, "factor"):
        frame = _without_blanks(rows.of(frame), name)
    _check_factor(rows.of(frame))
    frame = in_order(frame, problems)
    signed = _check_levels(rows.of(frame), answered=answered)
    quantity, factors = mapping.quantity, ["factor"]
    levels: tuple[str, ...] = (STIMULUS,)
    if not answered:
        kind = ESTIMATES
        read = clean_estimates(frame, rows.sources, problems, quantity, factors=factors)
    else:
        steps = one_row_per_answer(rows.of(frame))
        steps = _steps(without_missing(steps, ANSWER, mapping.answers.missing, problems))
        words = None if "yes_count" in mapping.columns.named else mapping.answers
        read = _above_reference(
            clean_differences(
                steps,
                *(rows.sources, problems, quantity),
                words=words,
                factors=factors,
                minimum=-LARGEST if signed else 0.0,
            )
        )
        kind, levels = DIFFERENCES, (STIMULUS, REFERENCE)
        if method := _method(read, mapping, signed=signed):
            kind, levels = CHOICES, ("track_level", "standard_level")
            read = _choices(read, method, mapping)
            read["task"] = _tasks(read, mapping, problems)
        else:
            _warn_of_forced_choice(read, problems, quantity)
    read = read.rename(columns={FACTOR + "factor": f"{FACTOR}{mapping.columns.factor}"})
    if mapping.stimulus.in_unit:
        for name in levels:
            read[name] = told_apart(read[name] * mapping.stimulus.factor, quantity)
    return {kind: read}


def _of_trials(rows: Rows) -> pd.DataFrame:
    """Omit rows with neither stimulus nor response, which PsychoPy writes for every routine.

    Rows without a level, a standard or an answer are counted in a note. Blank estimates are
    counted later.
    """
    frame = rows.frame
    content = [
        name for name in (RESPONSE, ANSWER, "yes_count", "no_count", "percent") if name in frame
    ]
    blank = frame[[STIMULUS, *content]].isna().all(axis=1)
    compared = [name for name in (STIMULUS, REFERENCE) if name in frame]
    unanswered = frame[content].isna().all(axis=1) & (RESPONSE not in frame)
    incomplete = (frame[compared].isna().any(axis=1) | unanswered) & ~blank
    where = f"{rows.sources[0].name}: " if len(rows.sources) == 1 else ""
    answered = frame[content].notna().any(axis=1)
    without = answered & frame[compared].isna().any(axis=1)
    if int(without.sum()) > MOST_WITHOUT * int(answered.sum()):
        raise UserError(
            "{file}: {count} of {answers} answers have no level or standard in their row; expected "
            "one answer per row, with its level. If a level is only in the first row of a block, "
            "fill the column downwards (pandas: ffill); if levels and answers are in separate "
            "rows, use --rows-of",
            file=rows.sources[0].name,
            count=int(without.sum()),
            answers=int(answered.sum()),
        )
    if incomplete.any():
        rows.problems.add(
            f"{where}{int(incomplete.sum())} of {int((~blank).sum())} trials without an answer, a "
            "level or a standard are omitted"
        )
    if blank.any():
        rows.problems.add(
            f"{where}{int(blank.sum())} rows with neither stimulus nor response were skipped"
        )
    return frame[~blank].reset_index(drop=True)


def _without_blanks(rows: Rows, name: str) -> pd.DataFrame:
    """Omit the rows without a label in a column, and report their lines."""
    frame = rows.frame
    blank = labels(frame, name, "").astype(str) == ""
    if name not in frame or not blank.any():
        return frame
    for file, own in frame[blank].groupby("file"):
        rows.problems.add(
            f"{rows.sources[int(str(file))].name}, {listed_lines(own['line'].tolist())}: omitted, "
            f"because there is no {rows.problems.title(name)}"
        )
    return frame[~blank].reset_index(drop=True)


def _check_factor(rows: Rows) -> None:
    """Raise `UserError` if every participant has only one value of the factor."""
    frame = rows.frame
    if "factor" not in frame:
        return
    values = frame.groupby(PARTICIPANT, observed=True)["factor"].nunique()
    if len(values) > 1 and values.max() == 1 < frame["factor"].nunique():
        raise UserError(
            "column {column}: each participant has only one value, so the column differs between "
            "people and is no factor; expected a condition that varies within participants. To "
            "compare groups of people, use --group {column}; to analyse one group, --only "
            "{column}=VALUE",
            column=rows.problems.title("factor"),
        )


def _check_levels(rows: Rows, *, answered: bool) -> bool:
    """Return whether the levels are offsets to both sides of a standard.

    Raises
    ------
    UserError
        If levels are below 0, but estimates or a forced choice require a true zero.
    """
    mapping, problems = rows.mapping, rows.problems
    levels = numbers(rows.frame, STIMULUS, rows.sources, Problems(titles=problems.titles))
    name, unit = mapping.quantity.name, mapping.stimulus.unit
    signed = bool((levels < 0).any())
    if signed and (not answered or mapping.answers.alternatives):
        way = (
            "for answers to offsets on both sides of a standard, omit --alternatives and state "
            "with --yes which answer means more"
            if answered
            else "convert a logarithm to the quantity; answers (--answer) may have negative offsets"
        )
        raise UserError(
            "{file}, column {column}: {name} of {least}; expected 0 or more, because the quantity "
            "must have a true zero and not be a logarithm or a difference; {way}",
            file=rows.sources[0].name,
            column=problems.title(STIMULUS),
            name=name,
            least=f"{levels.min():g} {unit}".rstrip(),
            way=way,
        )
    if not (signed or answered) and is_logarithmic(mapping):
        problems.add(
            f"{name} in {unit or 'this unit'} is already a logarithm, so "
            "exponents and growth functions do not refer to the underlying quantity; convert the "
            "levels first."
        )
    return signed


def is_logarithmic(mapping: TableMapping) -> bool:
    """Return whether the unit or the name of the levels is that of a logarithm, such as dB."""
    return bool(LOGARITHMIC.search(f"{mapping.stimulus.unit} {mapping.quantity.name}"))


def _tasks(choices: pd.DataFrame, mapping: TableMapping, problems: Problems) -> pd.Series[str]:
    """Return the task label of each trial: one task per standard, because functions differ."""
    standards = choices["standard_level"] * mapping.stimulus.factor
    apart = told_apart(standards, mapping.quantity).unique()
    if len(apart) < 2:  # noqa: PLR2004 - several
        return pd.Series(ANSWERS, choices.index)
    if len(apart) > MOST_STANDARDS:
        column = problems.title(REFERENCE)
        raise UserError(
            "column {column}: {standards} different standards; expected at most {most}, because"
            " one function is fitted per standard; select standards with --only {column}=...",
            column=column,
            standards=len(apart),
            most=MOST_STANDARDS,
        )
    unit = column_name("", mapping.quantity.unit)
    names = {
        each: f"{ANSWERS}_{np.format_float_positional(each, trim='-')}{unit}" for each in apart
    }
    return told_apart(standards, mapping.quantity).map(names)


def _steps(frame: pd.DataFrame) -> pd.DataFrame:
    """Return yes/no answers as steps from a reference to the stimulus (default reference: 0)."""
    found = frame.copy()
    if REFERENCE not in found:
        found[REFERENCE] = 0.0
    for name, missing in (("session", ""), ("run", "1")):
        found[name] = labels(found, name, missing)
    return found.rename(columns={BLOCK: SERIES})


def _above_reference(steps: pd.DataFrame) -> pd.DataFrame:
    """Exchange stimulus and reference, so that the step size is the stimulus minus the reference.

    In Slipscale's own tables, the step size is the decrease in amplitude.
    """
    return steps.rename(columns={REFERENCE: STIMULUS, STIMULUS: REFERENCE})


def _method(steps: pd.DataFrame, mapping: TableMapping, *, signed: bool) -> str:
    """Return the method for fitting answers, or "" if all stimuli are on one side of the reference.

    If stimuli are both below and above the reference, or offsets from it are, the trials are
    comparisons with a standard. If only the size of the difference were used, "more" answers below
    and above the reference would cancel out. Answers in several conditions are fitted as
    comparisons too, whose curves rise from "no" to "yes".
    """
    if mapping.answers.alternatives:
        return {2: "two_interval", 3: "three_interval"}[mapping.answers.alternatives]
    change = steps[REFERENCE] - steps[STIMULUS]
    both_sides = mapping.columns.reference and (change < 0).any() and (change > 0).any()
    return "comparison" if both_sides or signed or mapping.columns.factor else ""


def _choices(steps: pd.DataFrame, method: str, mapping: TableMapping) -> pd.DataFrame:
    """Convert answers to forced-choice trials or comparisons with a standard."""
    # The columns are swapped here, because `_above_reference` has exchanged them.
    level, standard = steps[REFERENCE], steps[STIMULUS]
    if method != "comparison":
        level = told_apart((level - standard).abs(), mapping.quantity)
    answered = steps["difference_felt"].notna() & level.notna() & standard.notna()
    return steps.assign(
        method=method,
        catch=False,
        track=np.nan,
        standard_level=standard,
        track_level=level,
        correct=steps["difference_felt"] == 1,
        response_time=np.nan,
    )[answered].reset_index(drop=True)


def _warn_of_forced_choice(steps: pd.DataFrame, problems: Problems, quantity: Quantity) -> None:
    """Warn if many "yes" answers at the smallest difference suggest a forced-choice task."""
    size = (steps[REFERENCE] - steps[STIMULUS]).abs()
    smallest = size[size > 0].min()
    answers = steps.loc[(size == smallest), "difference_felt"].dropna()
    if len(answers) >= FEWEST_TO_WARN and answers.mean() >= LIKE_GUESSING and not (size == 0).any():
        problems.add(
            f"At the smallest {quantity.name}, {smallest:g}, {answers.mean():.0%} of the answers "
            "are yes. If participants chose between alternatives in every trial, add "
            "--alternatives 2, so that guessing is not mistaken for sensitivity."
        )
