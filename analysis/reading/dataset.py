"""Define `Dataset`, which contains the trials to analyse and their sources."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd

from slipscale.analysis.reading.delimited import Source, digest
from slipscale.analysis.reading.labelled_tasks import TaskTrials
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: Fields of `Dataset` with trials of magnitude estimation and descending difference.
TABLES = ("estimates", "answers", "differences", "textures")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dataset:
    """Trials to analyse, with their sources.

    Parameters
    ----------
    name : str
        Title of the data set.
    estimates : DataFrame
        Trials of magnitude estimation: ``participant_id session run trial level estimate
        response_time scale_top modulus flag timed_out faulty``, one row per answered main trial, in
        order of presentation. The table is empty if the data contain no magnitude estimates.
    answers : DataFrame
        Main trials of magnitude estimation that were not voided, including unanswered trials,
        for assessing data quality.
    study_text : str
        Text of the study file used in the sessions; empty if it is not in the folder.
    textures : DataFrame
        Answered main trials with textures, which are named in the column ``texture``. Texture
        trials are not included in ``estimates`` and ``answers``.
    differences : DataFrame
        Answered steps of the descending difference task.
    trials : Mapping
        Answered main trials of all other kinds of task, keyed by the name of their `TaskTrials`. If
        a kind of task was not run, its entry may be missing; the method `of` then returns an empty
        table.
    others : Mapping
        Main trials of tasks that Slipscale cannot analyse (a laboratory's own protocols), keyed by
        task label; see `slipscale.analysis.reading.labelled_tasks.read_others`.
    participants : DataFrame
        Content of ``participants.tsv``; empty if it does not exist.
    mode : {"pilot", "participant", "unknown"}
        Whether answers come from simulated people or participants.
    counts : Mapping
        Number of rows read, and number excluded for each reason.
    details : Mapping
        Sidecar entries that describe the study, seeds, languages, plates and software.
    choices : AnalysisChoices
        Analysis choices from the study file, or the defaults.
    frozen : tuple of str
        Analysis choices that are set in the study file, by key.
    unchanged : bool or None
        Whether the sessions used the same study file. If so, the choices were made before data
        collection. None if the sidecars do not contain this information.
    journal_differences : tuple of str or None
        Differences between tables and journals, one sentence each; None without journals.
    problems : tuple of str
        Problems found, one sentence each.
    sources : tuple of Source
        All files that were read.
    left_out : tuple of str
        Names of files that could not be read, although others could.
    folder : Path or None
        The data set folder; None for a single table.
    quantity : Quantity
        Quantity in the column ``level``: the plate's amplitude, or the quantity that the
        data declare.
    """

    name: str
    estimates: pd.DataFrame
    answers: pd.DataFrame
    differences: pd.DataFrame
    participants: pd.DataFrame
    mode: str = "unknown"
    counts: Mapping[str, int] = field(default_factory=dict)
    details: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    choices: AnalysisChoices = field(default_factory=AnalysisChoices)
    frozen: tuple[str, ...] = ()
    unchanged: bool | None = None
    journal_differences: tuple[str, ...] | None = None
    problems: tuple[str, ...] = ()
    sources: tuple[Source, ...] = ()
    left_out: tuple[str, ...] = ()
    folder: Path | None = None
    quantity: Quantity = PLATE_AMPLITUDE
    study_text: str = ""
    textures: pd.DataFrame = field(default_factory=pd.DataFrame)
    trials: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    others: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    def of(self, kind: TaskTrials) -> pd.DataFrame:
        """Return the trials for a kind of task, or an empty table if no such task was run."""
        known = kind.name in TABLES
        found = getattr(self, kind.name) if known else self.trials.get(kind.name)
        return kind.empty() if found is None else found

    @property
    def tables(self) -> dict[str, pd.DataFrame]:
        """All trial tables, keyed by field name, kind of task, or task label."""
        own = {name: getattr(self, name) for name in TABLES}
        return {**own, **self.trials, **self.others}

    def with_tables(self, change: Callable[[pd.DataFrame], pd.DataFrame]) -> Dataset:
        """Return a copy of the data with ``change`` applied to every trial table."""
        changed: dict[str, Any] = {name: change(getattr(self, name)) for name in TABLES}
        for name in ("trials", "others"):
            changed[name] = {key: change(rows) for key, rows in getattr(self, name).items()}
        return replace(self, **changed)

    @property
    def tasks(self) -> list[pd.DataFrame]:
        """The trial tables of all kinds of task that the analysis supports."""
        return [self.estimates, self.differences, *self.trials.values()]

    @property
    def people(self) -> set[str]:
        """All participants with trials of any task, answered or not."""
        tasks = (self.answers, self.differences, *self.trials.values(), *self.others.values())
        return {str(who) for rows in tasks for who in rows[PARTICIPANT].unique()}

    @property
    def rows(self) -> pd.DataFrame:
        """The trials of the data set's first task, in the order of `tables`."""
        tables = [rows for name, rows in self.tables.items() if name != "answers"]
        return next((rows for rows in tables if len(rows)), self.estimates)

    def __len__(self) -> int:
        """Return the number of trials of all tasks."""
        return sum(len(rows) for name, rows in self.tables.items() if name != "answers")

    def __bool__(self) -> bool:
        """Return True, also for a data set without trials."""
        return True

    def __getitem__(self, column: str) -> pd.Series[Any]:
        """Return a column of `rows`."""
        return self.rows[column]

    def head(self, rows: int = 5) -> pd.DataFrame:
        """Return the first of the `rows`."""
        return self.rows.head(rows)

    def __repr__(self) -> str:
        """Summarise the data set in one line: name, mode, and numbers of people and trials."""
        trials = {name: len(rows) for name, rows in self.tables.items() if name != "answers"}
        counted = ", ".join(f"{count} {name}" for name, count in trials.items() if count)
        remarks = f"; {len(self.problems)} remarks (.problems)" if self.problems else ""
        return (
            f"Data set '{self.name}' ({self.mode}): {len(self.people)} participants; "
            f"{counted or 'no trials'}{remarks}"
        )

    @property
    def sha256(self) -> str:
        """SHA-256 of a sorted list with the SHA-256 and name of each file."""
        lines = sorted(f"{source.sha256}  {source.name}" for source in self.sources)
        return digest("\n".join(lines).encode())
