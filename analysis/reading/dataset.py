"""What the analysis is computed from: the trials, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import pandas as pd

from slipscale.analysis.reading.delimited import Source, digest
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from slipscale.analysis.reading.labelled_tasks import TaskTrials


#: The fields of `Dataset` that hold trials of magnitude estimation and descending difference.
TABLES = ("estimates", "answers", "differences", "textures")


@dataclass(frozen=True, slots=True, kw_only=True)
class Dataset:
    """Trials to analyse, and where they come from.

    Parameters
    ----------
    name : str
        The data set's title.
    estimates : DataFrame
        Trials of magnitude estimation: ``participant_id session run trial amplitude_um_pp
        estimate response_time scale_top modulus flag timed_out faulty``, one row an answered
        main trial, in order of presentation. Empty where there are none.
    answers : DataFrame
        All main trials of magnitude estimation that were not voided, answered or not: what data
        quality is judged by.
    study_text : str
        The study file that the sessions ran with; empty if it is not in the folder.
    textures : DataFrame
        Answered main trials of textures, which ``estimates`` and ``answers`` do not hold; with
        their ``texture``.
    differences : DataFrame
        Steps of the descending difference, answered ones.
    trials : Mapping
        Answered main trials of every other kind of task, by the name of its `TaskTrials`; `of`
        looks them up. Kinds that were not run may be missing.
    others : Mapping
        Main trials of tasks that are read by no analysis of Slipscale's (a laboratory's own
        protocols), as `slipscale.analysis.reading.labelled_tasks.read_others` returns them, by task
        label.
    participants : DataFrame
        ``participants.tsv``, where there is one.
    mode : {"pilot", "participant", "unknown"}
        Whose answers these are.
    counts : Mapping
        Rows read and left out, by reason.
    details : Mapping
        What the sidecars say of study, seeds, languages, plates and software.
    choices : AnalysisChoices
        The frozen choices, or the defaults.
    frozen : tuple of str
        The keys that the study file sets.
    unchanged : bool or None
        Whether that file is the one that the sessions ran with, so that they were frozen before
        there was data; None where the sidecars do not say.
    journal_differences : tuple of str or None
        How the tables differ from the journals, one sentence each; None without journals.
    problems : tuple of str
        One sentence each.
    sources : tuple of Source
        Every file that was read.
    folder : Path or None
        The data set's folder; None for a table by hand.
    quantity : Quantity
        What ``amplitude_um_pp`` holds: the plate's amplitude, or what the data say.
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
    folder: Path | None = None
    quantity: Quantity = PLATE_AMPLITUDE
    study_text: str = ""
    textures: pd.DataFrame = field(default_factory=pd.DataFrame)
    trials: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    others: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    def of(self, kind: TaskTrials) -> pd.DataFrame:
        """Return the trials of a kind of task; no row if it was not run."""
        known = kind.name in TABLES
        found = getattr(self, kind.name) if known else self.trials.get(kind.name)
        return kind.empty() if found is None else found

    @property
    def tables(self) -> dict[str, pd.DataFrame]:
        """All tables of trials, by their field, kind or label."""
        own = {name: getattr(self, name) for name in TABLES}
        return {**own, **self.trials, **self.others}

    def with_tables(self, change: Callable[[pd.DataFrame], pd.DataFrame]) -> Dataset:
        """Return the data with every table of trials changed alike."""
        changed: dict[str, Any] = {name: change(getattr(self, name)) for name in TABLES}
        for name in ("trials", "others"):
            changed[name] = {key: change(rows) for key, rows in getattr(self, name).items()}
        return replace(self, **changed)

    @property
    def tasks(self) -> list[pd.DataFrame]:
        """The trials of every kind of task that the analysis reads."""
        return [self.estimates, self.differences, *self.trials.values()]

    @property
    def people(self) -> set[str]:
        """Everybody who has trials of any task, answered or not."""
        tasks = (self.answers, self.differences, *self.trials.values(), *self.others.values())
        return {str(who) for rows in tasks for who in rows[PARTICIPANT].unique()}

    def __repr__(self) -> str:
        """Return one line: the title, and how many participants and trials of each kind."""
        trials = {name: len(rows) for name, rows in self.tables.items() if name != "answers"}
        counted = ", ".join(f"{count} {name}" for name, count in trials.items() if count)
        remarks = f"; {len(self.problems)} remarks (.problems)" if self.problems else ""
        return (
            f"Data set '{self.name}' ({self.mode}): {len(self.people)} participants; "
            f"{counted or 'no trials'}{remarks}"
        )

    @property
    def sha256(self) -> str:
        """One digest for all files, in the order of their names."""
        lines = sorted(f"{source.sha256}  {source.name}" for source in self.sources)
        return digest("\n".join(lines).encode())
