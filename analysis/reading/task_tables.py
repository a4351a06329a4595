"""Read trial tables for any kind of task that declares its columns.

The same rules apply to all kinds of task:

- a table belongs to the kind if it has every column in ``marks``;
- practice trials, voided trials and trials without an answer are counted and excluded;
- trials with an unknown code, such as an unknown direction, are reported and excluded;
- columns that are not declared are not read;
- in a study with factors, each condition is a separate task, with the factor levels in its label.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from slipscale.analysis.reading.answer_codes import TRUE
from slipscale.analysis.reading.cells import cell, places
from slipscale.analysis.reading.cleaning import labels, numbers, told_apart
from slipscale.analysis.reading.delimited import LISTED_PROBLEMS, Problems, Source, quantity_of
from slipscale.analysis.reading.labelled_tasks import (
    Entries,
    TaskTrials,
    add_counts,
    factors_of,
    read_main_trials,
    with_people,
)
from slipscale.analysis.reading.surface_labels import padded, plain
from slipscale.analysis.reading.trial_tables import FACTOR, IDENTITY

COMMON = (*IDENTITY, "task", "trial", "catch")
#: In a study with factors, the column that contains the task label without the condition.
BEFORE_CONDITION = "task of all conditions"


def by_task(rows: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Group trials by task label; numbers in labels are sorted by value."""
    groups = {str(task): own for task, own in rows.groupby("task")} if len(rows) else {}
    return [(task, groups[task]) for task in sorted(groups, key=padded)]


def empty(columns: tuple[str, ...]) -> pd.DataFrame:
    """Return an empty table with the given columns."""
    return pd.DataFrame({name: pd.Series(dtype=object) for name in columns})


def task_trials(
    name: str,
    title: str,
    *,
    marks: tuple[str, ...],
    numeric: tuple[str, ...],
    words: tuple[str, ...] = (),
    codes: Mapping[str, tuple[str, ...]] | None = None,
    columns: tuple[str, ...],
    needed: tuple[str, ...],
    required: tuple[str, ...] = (),
    levels: tuple[str, ...] = (),
    derive: Callable[[pd.DataFrame, Problems], pd.DataFrame],
) -> TaskTrials:
    """Declare a kind of task by the columns of its tables.

    Parameters
    ----------
    name, title : str
        See `TaskTrials`. The title is also the prefix for the keys of row counts, as in
        ``{title}_rows``.
    marks : tuple of str
        Columns by which a table is recognised.
    numeric : tuple of str
        Numeric columns with values of at least 0. Columns other than those in ``marks`` may be
        absent, in which case their values are NaN.
    words : tuple of str
        Columns of labels. Absent columns are filled with empty labels.
    codes : Mapping, optional
        Columns with a fixed set of labels, as column -> labels.
    columns : tuple of str
        Columns of the returned table, in addition to `COMMON`.
    needed : tuple of str
        Columns that must contain a value for a trial to count as answered.
    required : tuple of str
        Required columns, in addition to ``marks``.
    levels : tuple of str
        Columns with levels. The levels are rounded so that floating-point errors do not create
        additional levels.
    derive : callable
        Function that adds derived columns and sets unusable answers to NaN.
    """
    kept_columns = (*COMMON, *columns)
    fixed = codes or {}

    def read(
        entries: Entries, folder: Path, problems: Problems, counts: dict[str, int]
    ) -> tuple[pd.DataFrame, list[Source]]:
        if not entries:
            return empty(kept_columns), []
        factors = factors_of(folder)
        frame, sources = read_main_trials(
            entries,
            folder,
            kind=title,
            required=(*marks, *required),
            columns=tuple(
                dict.fromkeys(("trial", "catch", *marks, *numeric, *words, *fixed, *factors))
            ),
            problems=problems,
            counts=counts,
        )
        crossed = [name for name in factors if name in frame]
        if crossed:
            frame[BEFORE_CONDITION] = frame["task"]
        for factor in crossed:
            frame[f"{FACTOR}{factor}"] = labels(frame, factor, "")
            frame["task"] += f"_{factor}-" + labels(frame, factor, "").astype(str).map(plain)
        frame["catch"] = labels(frame, "catch", "false").astype(str).str.lower().isin(TRUE)
        for word in words:
            frame[word] = labels(frame, word, "").astype(str)
        for column, known in fixed.items():
            frame[column] = _known(frame, column, known, sources, problems)
        for number in ("trial", *numeric):
            frame[number] = (
                numbers(frame, number, sources, problems, minimum=0.0)
                if number in frame
                else np.nan
            )
        quantity = quantity_of(entries[0][0])
        for level in levels:
            frame[level] = told_apart(frame[level], quantity)
        frame = derive(frame, problems)
        answered = frame[[*needed, *fixed]].notna().all(axis=1)
        kept = frame[answered]
        add_counts(counts, title, unanswered=(~answered).sum(), analysed=len(kept))
        of_conditions = [f"{FACTOR}{factor}" for factor in crossed]
        of_conditions += [BEFORE_CONDITION] if crossed else []
        return with_people(kept, (*kept_columns, *of_conditions)), sources

    return TaskTrials(
        name=name,
        counted=title,
        title=title,
        belongs=lambda header: header.issuperset(marks),
        read=read,
        empty=partial(empty, kept_columns),
    )


def _known(
    frame: pd.DataFrame,
    column: str,
    known: Sequence[str],
    sources: Sequence[Source],
    problems: Problems,
) -> pd.Series[str]:
    """Return a column's labels, with NaN for labels other than the known ones, and report these."""
    found = labels(frame, column, "").astype(str)
    wrong = ~found.isin(known)
    shown = frame[wrong].head(LISTED_PROBLEMS)
    problems.add_many(
        [
            f"{place}, column {column}: '{cell(label)}' instead of {' or '.join(known)}; "
            "the trial is left out"
            for place, label in zip(places(shown, sources), found[shown.index], strict=True)
        ],
        f"column {column}",
        int(wrong.sum()),
    )
    return found.mask(wrong)


def above_zero(values: pd.Series[float], what: str, problems: Problems) -> pd.Series[float]:
    """Remove values of 0, which have no logarithm, and report their number."""
    zero = values == 0
    if zero.any():
        problems.add(f"{int(zero.sum())} {what} are 0; they cannot form a ratio and are omitted")
    return values.mask(zero)
