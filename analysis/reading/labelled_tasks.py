"""Identify the kind of a task from its columns, because studies choose their own task labels.

If a study has several tasks of one kind, with different labels, each task is analysed separately.
Magnitude estimation and descending difference (the kinds with a `TaskTrials.label`) are exceptions:
only one label is analysed, and the remaining labels are reported.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from slipscale.analysis.reading.cleaning import labels, tidied
from slipscale.analysis.reading.delimited import (
    Problems,
    Source,
    header_of,
    quantity_of,
    read_bytes,
    read_tables,
)
from slipscale.analysis.reading.dialect import decoded
from slipscale.analysis.reading.trial_tables import set_aside
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.faults.toml_file import toml_table
from slipscale.stimuli.level_names import is_level

Entry = tuple[Path, re.Match[str]]
Entries = Sequence[Entry]


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskTrials:
    """Declaration of one kind of task and its trial tables.

    Parameters
    ----------
    name : str
        Key in `Dataset.trials`.
    counted : str
        Prefix for the keys of row counts, as in ``{counted}_rows`` and ``{counted}_unanswered``.
    title : str
        Name of the kind of task, used in messages after "trials of".
    belongs : callable
        Function that returns whether a table with the given columns belongs to this kind of task.
    read : callable
        Function that reads tables, and returns the answered main trials and their source files.
    empty : callable
        Function that returns an empty table with the columns of the answered trials.
    label : str
        Default task label. Set only if a single label of this kind is analysed.
    divide : callable, optional
        Function that splits the rows into tables, keyed by name in `Dataset`. By default, all rows
        form a single table.
    reasons : Mapping
        Descriptions of omitted rows, keyed by the name of the row count. The default describes
        practice trials, voided trials and unanswered trials.
    """

    name: str
    counted: str
    title: str
    belongs: Callable[[frozenset[str]], bool]
    read: Callable[[Entries, Path, Problems, dict[str, int]], tuple[pd.DataFrame, list[Source]]]
    empty: Callable[[], pd.DataFrame]
    label: str = ""
    divide: Callable[[pd.DataFrame, Problems, dict[str, int]], dict[str, pd.DataFrame]] | None = (
        None
    )
    reasons: Mapping[str, str] = field(default_factory=dict)

    @property
    def left_out(self) -> Mapping[str, str]:
        """Descriptions of omitted rows, keyed by the name of the row count."""
        return self.reasons or {
            f"{self.counted}_practice": f"practice trials of {self.title}",
            f"{self.counted}_voided": f"voided trials of {self.title}",
            f"{self.counted}_unanswered": f"trials of {self.title} without a usable answer",
        }

    def counted_left_out(self, counts: Mapping[str, int]) -> list[str]:
        """Describe how many rows were omitted and why, such as "1 practice trial"."""
        reasons = {
            **self.left_out,
            f"{self.counted}_excluded": "answered trials of excluded participants",
        }
        return [
            f"{n} {why if n != 1 else why.replace('trials', 'trial', 1)}"
            for name, why in reasons.items()
            if (n := counts.get(name, 0))
        ]


#: Column for each key in a file name.
IDENTITY_OF = {"sub": PARTICIPANT, "ses": "session", "task": "task", "run": "run"}


def columns_of(path: Path) -> frozenset[str]:
    """Return a table's column names as in the code.

    A name that ends in the unit of the levels, such as a time in a study in s, is also returned
    unchanged, because the name alone does not reveal whether the column contains levels.
    """
    names, in_names = header_of(path), quantity_of(path).in_code
    return frozenset(in_names[name] for name in names) | {n for n in names if not is_level(n)}


def kind_of(task: str, path: Path, kinds: Sequence[TaskTrials]) -> TaskTrials | None:
    """Identify the kind of a task by its label, or by its columns if the label is unknown."""
    by_label = next((kind for kind in kinds if kind.label == task), None)
    if by_label is not None:
        return by_label
    header = columns_of(path)
    return next((kind for kind in kinds if kind.belongs(header)), None)


def of_one_label(
    kind: TaskTrials,
    tasks: Mapping[str, Entries],
    wanted: str | None,
    problems: Problems,
) -> Entries:
    """Return the tables of one task label, and report labels that are not analysed.

    Parameters
    ----------
    tasks : Mapping
        Tables, keyed by task label.
    wanted : str or None
        The requested label, if it belongs to this kind of task.
    """
    usual = kind.label if kind.label in tasks else min(tasks, default=kind.label)
    label = wanted if wanted is not None and wanted in tasks else usual
    if left := sorted(set(tasks) - {label}):
        problems.add(
            f"{kind.title} occurs under several labels: only '{label}' is analysed, not "
            f"{' and '.join(repr(each) for each in left)}; to analyse another label, run "
            f"slipscale analyse --task {left[0]}"
        )
    return tasks.get(label, [])


def read_main_trials(
    entries: Entries,
    folder: Path,
    *,
    kind: str,
    required: tuple[str, ...],
    columns: tuple[str, ...],
    problems: Problems,
    counts: dict[str, int],
) -> tuple[pd.DataFrame, list[Source]]:
    """Read the trials that are neither practice nor voided.

    Parameters
    ----------
    entries : sequence of (Path, Match)
        Path of each table, and the match of its file name with the regular expression
        `slipscale.experiments.dataset.schema.TABLE_NAME`.
    kind : str
        Prefix for the keys of row counts, as in ``{kind}_rows``.
    required, columns : tuple of str
        Required columns, and all columns to read.
    counts : dict
        Row counts; updated in place.
    """
    frame, sources = read_tables(
        [path for path, _ in entries],
        folder,
        required=required,
        columns=(*columns, "phase", "flag"),
        problems=problems,
    )
    place = frame["file"].to_numpy()
    for group, name in IDENTITY_OF.items():
        values = np.array([match[group] or "" for _, match in entries], dtype=object)
        frame[name] = values[place]
    frame[PARTICIPANT] = "sub-" + frame[PARTICIPANT].astype(str)
    frame["flag"] = labels(frame, "flag", "").astype(str)
    practice, voided = set_aside(frame.assign(phase=labels(frame, "phase", "")))
    add_counts(counts, kind, rows=len(frame), practice=practice.sum(), voided=voided.sum())
    return frame[~practice & ~voided].reset_index(drop=True), sources


def factors_of(folder: Path) -> tuple[str, ...]:
    """Return the names of the study's factors, which are columns in every task's table."""
    return tuple(str(row["name"]) for row in _study_rows(folder, "factors") if "name" in row)


def labels_of(folder: Path, protocol: str) -> set[str]:
    """Return the labels of the study's tasks that ran a protocol, as in file names."""
    rows = [row for row in _study_rows(folder, "tasks") if row.get("protocol") == protocol]
    return {str(row.get("label", protocol)) for row in rows}


def _study_rows(folder: Path, name: str) -> list[Mapping[str, object]]:
    path = folder / "code" / "study.toml"
    if not path.is_file():
        return []
    text = decoded(read_bytes(path), path)[0].decode("utf-8")
    stated = toml_table(text, str(path)).get(name, [])
    return [row for row in stated if isinstance(row, dict)] if isinstance(stated, list) else []


def add_counts(counts: dict[str, int], kind: str, **more: int) -> None:
    """Increase row counts; ``kind`` is the prefix of their keys, as in ``{kind}_rows``."""
    for name, count in more.items():
        key = f"{kind}_{name}"
        counts[key] = counts.get(key, 0) + int(count)


def read_others(
    others: Mapping[str, Entries], folder: Path, problems: Problems, counts: dict[str, int]
) -> tuple[dict[str, pd.DataFrame], list[Source]]:
    """Read main trials of tasks that Slipscale cannot analyse; return tables keyed by label.

    The tables contain all columns of the files, with numbers parsed. The columns
    ``participant_id``, ``session``, ``task`` and ``run`` are taken from the file names. Unanswered
    trials are included.
    """
    tasks: dict[str, pd.DataFrame] = {}
    sources: list[Source] = []
    for task, entries in sorted(others.items()):
        columns = frozenset().union(*(columns_of(path) for path, _ in entries))
        frame, read_sources = read_main_trials(
            entries,
            folder,
            kind=f"task_{task}",
            required=(),
            columns=tuple(sorted(columns - {"phase", "flag"})),  # read in any case
            problems=problems,
            counts=counts,
        )
        frame[PARTICIPANT] = pd.Categorical(frame[PARTICIPANT].astype(str))
        tasks[task] = frame.drop(columns=["file", "line"])
        sources += read_sources
    return tasks, sources


def with_people(rows: pd.DataFrame, columns: tuple[str, ...]) -> pd.DataFrame:
    """Select columns, and convert participant labels to a categorical."""
    people = tidied(rows[PARTICIPANT]).cat.remove_unused_categories()
    return rows.assign(**{PARTICIPANT: people})[list(columns)].reset_index(drop=True)
