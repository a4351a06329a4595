"""Convert answers, counts of answers and ratings of pairs to Slipscale's format."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import without_missing
from slipscale.analysis.reading.cells import places
from slipscale.analysis.reading.cleaning import (
    clean_differences,
    empty_differences,
    labels,
    numbers,
    tidied,
    told_apart,
)
from slipscale.analysis.reading.delimited import Problems, Source
from slipscale.analysis.reading.foreign.columns import ANSWER, REFERENCE, STIMULUS
from slipscale.analysis.reading.mapping import column_name
from slipscale.analysis.reading.trial_tables import BLOCK, SERIES
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.mapping import TableMapping
    from slipscale.stimuli.quantity import Quantity

#: Label of the task in a table of answers.
ANSWERS = "answers"
#: Maximum number of standards, because one function is fitted per standard.
MOST_STANDARDS = 12
#: Number of answers at the smallest level, and proportion of "yes" that suggests guessing.
FEWEST_TO_WARN, LIKE_GUESSING = 10, 1 / 3


def read_answers(
    frame: pd.DataFrame, mapping: TableMapping, sources: Sequence[Source], problems: Problems
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the answers as yes-no differences and as forced choices; one of them is empty.

    Raises
    ------
    UserError
        If there are too many standards, or yes-no answers in different conditions.
    """
    rows = _one_row_per_answer(frame, mapping, sources, problems)
    steps = _steps(without_missing(rows, ANSWER, mapping.answers.missing, problems))
    quantity = mapping.quantity
    read = _above_reference(
        clean_differences(
            steps, sources, problems, quantity, words=mapping.answers, factors=["factor"]
        )
    )
    if method := _method(read, mapping):
        choices = _choices(read, method, quantity, problems)
        return empty_differences(), choices.assign(task=_tasks(choices, mapping, problems))
    if mapping.columns.factor:
        raise UserError(
            "{file}, column {factor}: a factor cannot be combined with yes-no answers; expected"
            " magnitude estimates, a forced choice (--alternatives), or one condition at a time"
            " (--only {factor}=...)",
            file=sources[0].name,
            factor=mapping.columns.factor,
        )
    _warn_of_forced_choice(read, problems, quantity)
    return read, pd.DataFrame()


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


def _one_row_per_answer(
    frame: pd.DataFrame, mapping: TableMapping, sources: Sequence[Source], problems: Problems
) -> pd.DataFrame:
    """Expand counts of yes answers to one row per answer; leave other tables unchanged.

    Raises
    ------
    UserError
        If a count is not a whole number from 0 to n.
    """
    if not mapping.columns.yes_count:
        return frame
    yes, n = (numbers(frame, name, sources, problems) for name in ("yes_count", "n"))
    wrong = ~((yes >= 0) & (yes <= n) & (yes % 1 == 0) & (n % 1 == 0))
    if wrong.any():
        at = int(wrong.to_numpy().argmax())
        raise UserError(
            "{place}: {count_column} is {count} and {n_column} {n}; expected whole numbers, "
            "with 0 to n yes answers",
            place=places(frame.iloc[[at]], sources)[0],
            count_column=problems.title("yes_count"),
            count=frame["yes_count"].iloc[at],
            n_column=problems.title("n"),
            n=frame["n"].iloc[at],
        )
    times = np.stack([yes, n - yes], axis=1).astype(int).ravel()
    rows = frame.loc[frame.index.repeat(2)].assign(**{ANSWER: ["yes", "no"] * len(frame)})
    return rows.iloc[np.repeat(np.arange(len(rows)), times)].reset_index(drop=True)


def _steps(frame: pd.DataFrame) -> pd.DataFrame:
    """Return yes/no answers as steps from a reference to the stimulus (default reference: 0)."""
    found = frame.copy()
    if REFERENCE not in found:
        found[REFERENCE] = 0.0
    found[PARTICIPANT] = tidied(found[PARTICIPANT])
    for name, missing in (("session", ""), ("run", "1")):
        found[name] = labels(found, name, missing)
    return found.rename(columns={BLOCK: SERIES})


def _above_reference(steps: pd.DataFrame) -> pd.DataFrame:
    """Exchange stimulus and reference, so that the step size is the stimulus minus the reference.

    In Slipscale's own tables, the step size is the decrease in amplitude.
    """
    return steps.rename(columns={REFERENCE: STIMULUS, STIMULUS: REFERENCE})


def _method(steps: pd.DataFrame, mapping: TableMapping) -> str:
    """Return the method for fitting answers, or "" if all stimuli are on one side of the reference.

    If stimuli are both below and above the reference, the trials are comparisons with a standard.
    If only the size of the difference were used, "more" answers below and above the reference would
    cancel out.
    """
    if mapping.answers.alternatives:
        return {2: "two_interval", 3: "three_interval"}[mapping.answers.alternatives]
    change = steps[REFERENCE] - steps[STIMULUS]
    both_sides = mapping.columns.reference and (change < 0).any() and (change > 0).any()
    return "comparison" if both_sides else ""


def _choices(
    steps: pd.DataFrame, method: str, quantity: Quantity, problems: Problems
) -> pd.DataFrame:
    """Convert answers to forced-choice trials or comparisons with a standard."""
    # The columns are swapped here, because `_above_reference` has exchanged them.
    level, standard = steps[REFERENCE], steps[STIMULUS]
    if method != "comparison":
        level = told_apart((level - standard).abs(), quantity)
    answered = steps["difference_felt"].notna() & level.notna() & standard.notna()
    if not answered.all():
        problems.add(
            f"{int((~answered).sum())} trials without an answer, a level or a standard are omitted"
        )
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


def read_pairs(frame: pd.DataFrame, sources: Sequence[Source], problems: Problems) -> pd.DataFrame:
    """Convert the table to ratings of pairs of named items."""
    rated = frame.assign(
        **{name: labels(frame, name, "").astype(str) for name in ("first", "second")},
        **{name: labels(frame, name, missing) for name, missing in (("session", ""), ("run", "1"))},
        **{PARTICIPANT: tidied(frame[PARTICIPANT])},
        dissimilarity=numbers(frame, "dissimilarity", sources, problems, minimum=0.0),
        task="similarity",
        trial=range(1, len(frame) + 1),
        catch=False,
        sorted=False,
    )
    whole = rated["dissimilarity"].notna() & (rated["first"] != "") & (rated["second"] != "")
    if not whole.all():
        problems.add(f"{int((~whole).sum())} ratings without a number or an item are omitted")
    return rated[whole].reset_index(drop=True)
