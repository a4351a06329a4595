"""Read forced-choice and constant-stimuli trials.

Tables are recognised by their columns, because task labels differ between studies.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import TRUE, own_answers
from slipscale.analysis.reading.cleaning import labels, numbers, told_apart
from slipscale.analysis.reading.delimited import Problems, Source, quantity_of
from slipscale.analysis.reading.labelled_tasks import (
    TaskTrials,
    add_counts,
    columns_of,
    factors_of,
    labels_of,
    read_main_trials,
)
from slipscale.analysis.reading.trial_tables import FACTOR, IDENTITY
from slipscale.analysis.tasks.thresholds.friction_axis import OTHER_FRICTION, TARGET_FRICTION
from slipscale.experiments.dataset.measured import COEFFICIENT
from slipscale.experiments.dataset.schema import INTERVAL, PARTICIPANT
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: The protocol whose question names no attribute, and its method.
ODDITY = "oddity"
#: Columns for the level and the answer, by which a table is recognised.
FORCED_CHOICE = ("track_level", "correct")
COMPARISON = ("comparison_level", "comparison_more")
NUMBERS = ("trial", "track", "track_level", "standard_level", "response_time")
COLUMNS = (
    *IDENTITY,
    *("task", "method", "trial", "track", "catch", "standard_level", "track_level"),
    *("correct", "response_time", "flag", TARGET_FRICTION, OTHER_FRICTION),
)
#: Columns that give the number of the interval with the target (the odd stimulus or the
#: comparison).
TARGET = ("target_interval", "comparison_interval")
FRICTION = tuple(f"{INTERVAL}{number}_{COEFFICIENT}" for number in (1, 2, 3))


def empty_choices() -> pd.DataFrame:
    """Return an empty table with the columns of `read_choices`."""
    return pd.DataFrame({name: pd.Series(dtype=object) for name in COLUMNS}).astype(
        dict.fromkeys(("track_level", "standard_level", "track", "response_time"), float)
    )


def is_choice(header: frozenset[str]) -> bool:
    """Return whether a table contains forced-choice or constant-stimuli trials."""
    return any(header.issuperset(marks) for marks in (FORCED_CHOICE, COMPARISON))


def read_choices(
    entries: Sequence[tuple[Path, re.Match[str]]],
    folder: Path,
    problems: Problems,
    counts: dict[str, int],
) -> tuple[pd.DataFrame, list[Source]]:
    """Return the main trials that were answered, in order of presentation.

    Parameters
    ----------
    entries : sequence of (Path, Match)
        Table files, each with the match object of `slipscale.experiments.dataset.schema.TABLE_NAME`
        for its file name.
    counts : dict
        Updated in place with the number of rows read and the number of rows excluded for each
        reason.

    Returns
    -------
    trials, sources : DataFrame, list of Source
        Trials with the columns `COLUMNS` and one column per study factor, whose name is the
        factor's name with the prefix `FACTOR`. ``method`` is a key of
        `slipscale.analysis.statistics.psychometrics.psychometric_function.METHODS`; ``catch`` and
        ``correct`` are Boolean. In a comparison, ``correct`` means that the comparison stimulus was
        judged more slippery.
    """
    frames, sources = [], []
    for marks in (FORCED_CHOICE, COMPARISON):
        own = [entry for entry in entries if columns_of(entry[0]).issuperset(marks)]
        if own:
            frame, read = _read(own, marks, folder, problems, counts)
            frames.append(frame)
            sources += read
    if not frames:
        return empty_choices(), []
    everything = pd.concat(frames, ignore_index=True)
    people = pd.Categorical(everything[PARTICIPANT].astype(str))
    return everything.assign(**{PARTICIPANT: people}), sources


def _read(
    entries: Sequence[tuple[Path, re.Match[str]]],
    marks: tuple[str, str],
    folder: Path,
    problems: Problems,
    counts: dict[str, int],
) -> tuple[pd.DataFrame, list[Source]]:
    level = marks[0]
    third = f"{INTERVAL}3_surface"
    factors = factors_of(folder)
    frame, sources = read_main_trials(
        entries,
        folder,
        kind="choice",
        required=marks,
        columns=(
            *("trial", "track", "catch", "standard_level", *marks),
            *("response", "response_time", third, *TARGET, *FRICTION),
            *factors,
        ),
        problems=problems,
        counts=counts,
    )
    for name in NUMBERS:
        read = level if name == FORCED_CHOICE[0] else name
        frame[name] = (
            numbers(frame, read, sources, problems, minimum=0.0) if read in frame else np.nan
        )
    frame = frame.assign(**_friction(frame, sources, problems))
    crossed = [name for name in factors if name in frame]
    frame = frame.assign(**{FACTOR + name: labels(frame, name, "") for name in crossed})
    odd = labels_of(folder, ODDITY) | {ODDITY}
    choices = told_choices(frame, marks, quantity_of(entries[0][0]), odd=odd)
    answered = choices["correct"].notna() & choices["track_level"].notna()
    kept = choices[answered]
    add_counts(counts, "choice", unanswered=(~answered).sum(), analysed=len(kept))
    columns = [*COLUMNS, *(FACTOR + name for name in crossed)]
    return kept.astype({"correct": bool})[columns].reset_index(drop=True), sources


def _friction(
    frame: pd.DataFrame, sources: list[Source], problems: Problems
) -> dict[str, pd.Series[float]]:
    """Return the friction coefficient in the target's interval and its mean in other intervals."""
    measured = frame.reindex(columns=list(FRICTION)).astype(float)
    for name in frame.columns.intersection(list(FRICTION)):
        measured[name] = numbers(frame, name, sources, problems, minimum=0.0)
    target = np.zeros(measured.shape, bool)
    for name in frame.columns.intersection(list(TARGET)):
        place = numbers(frame, name, sources, problems).to_numpy()[:, None]
        target |= place == np.arange(1, len(FRICTION) + 1)
    return {
        TARGET_FRICTION: measured.where(target).mean(axis=1),
        OTHER_FRICTION: measured.mask(target).mean(axis=1),
    }


def told_choices(
    frame: pd.DataFrame,
    marks: tuple[str, str],
    quantity: Quantity = PLATE_AMPLITUDE,
    *,
    odd: Collection[str] = (ODDITY,),
) -> pd.DataFrame:
    """Add the columns ``method``, ``catch`` and ``correct``, and convert levels for fitting.

    Parameters
    ----------
    frame : DataFrame
        Trials of one format, with parsed numbers.
    marks : tuple of str
        The format of the table: `FORCED_CHOICE` or `COMPARISON`.
    odd : collection of str
        Labels of tasks in which participants chose the odd stimulus.
    """
    _, answer = marks
    third = f"{INTERVAL}3_surface"
    frame = frame.copy()
    frame["correct"] = own_answers(frame[answer])
    frame["catch"] = labels(frame, "catch", "false").astype(str).str.lower().isin(TRUE)
    if marks == FORCED_CHOICE:
        has_third = frame[third].notna() if third in frame else pd.Series(False, frame.index)
        three = has_third.groupby(frame["task"]).transform("any")
        method = three.map({True: "three_interval", False: "two_interval"})
        label = frame["task"].map(lambda task: str(task).partition("_")[0])
        frame["method"] = method.mask(label.isin(list(odd)), ODDITY)
    else:
        frame["method"] = frame["task"].map(_methods(frame))
        _one_sided(frame, quantity)
    return frame


def _methods(frame: pd.DataFrame) -> dict[str, str]:
    """Return "two_interval" or "comparison" for each task with constant stimuli.

    Answers are right or wrong (two-interval) if all levels lie on one side of the standard and
    participants choose an interval. In all other tasks, levels are compared with the standard.
    """
    found = {}
    for task, rows in frame.groupby("task"):
        apart = rows["track_level"] - rows["standard_level"]
        chosen = rows["response"].dropna().astype(str).isin(["1", "2"]).all()
        one_side = bool((apart.dropna() > 0).all() or (apart.dropna() < 0).all())
        found[str(task)] = "two_interval" if chosen and one_side else "comparison"
    return found


def _one_sided(frame: pd.DataFrame, quantity: Quantity) -> None:
    """In one-sided tasks, replace levels by differences, and answers by right or wrong."""
    rows = frame["method"] == "two_interval"
    apart = (frame["track_level"] - frame["standard_level"])[rows]
    right = frame.loc[rows, "correct"].where(apart > 0, 1 - frame.loc[rows, "correct"])
    frame.loc[rows, "correct"] = right
    frame.loc[rows, "track_level"] = told_apart(apart.abs(), quantity)


TRIALS = TaskTrials(
    name="forced_choices",
    counted="choice",
    title="forced choice",
    belongs=is_choice,
    read=read_choices,
    empty=empty_choices,
)
