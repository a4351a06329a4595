"""Represent the result of an analysis, and declare kinds of task.

Each folder in `slipscale.analysis.tasks` and its ``effects`` contains one kind, the counterpart of
a session's `Protocol`. Its ``declaration`` lists everything that the report and its files show
about it, and `slipscale.analysis.tasks.table` lists the declarations. Other packages declare
theirs with an entry point; see `slipscale.analysis.tasks.outside`. A small kind has two modules:
``statistics`` (its trials and results) and ``declaration`` (its sentences, section and figures).
Rules:

- shared code (loading, inference, page, files, plans) loops over `Analysis.kinds` and names no
  particular kind;
- every callable takes the whole `Analysis` and returns an empty result if the kind was not run.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from types import ModuleType

    import pandas as pd
    from matplotlib.figure import Figure

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.reading.labelled_tasks import TaskTrials
    from slipscale.analysis.statistics.measured_friction import MeasuredFriction
    from slipscale.analysis.statistics.robustness import SubsetSummary
    from slipscale.analysis.statistics.sensitivity import RuleSummary
    from slipscale.analysis.statistics.statistic import Inference, SessionTable, Statistic
    from slipscale.analysis.writing.html import ReportSection

    SectionWriter = Callable[["Analysis", Mapping[str, str]], ReportSection]


def _nothing_to_say(_analysis: Analysis) -> list[str]:
    return []


def _nothing_titled(_analysis: Analysis) -> dict[str, list[str]]:
    return {}


def _no_figures(_analysis: Analysis) -> dict[str, Figure]:
    return {}


def _no_tables(_analysis: Analysis) -> dict[str, pd.DataFrame]:
    return {}


def _no_sessions(_data: Dataset, _prepared: Prepared | None) -> tuple[SessionTable, ...]:
    return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskAnalysis:
    """A kind of task, as declared for the analysis.

    Parameters
    ----------
    name : str
        Name of its folder.
    trials : TaskTrials, optional
        Which tables contain its trials, and how to read them; a study can choose the task label.
    statistics : tuple of Statistic
        Its statistics, in the order of computation and of ``inference.json``.
    questions : callable
        Returns the questions at the start of the report's summary.
    design : callable
        Returns the numbers of trials and surfaces.
    answers : callable
        Returns the sentences for the summary.
    doubts : callable
        Returns the caveats for the summary.
    sentences : callable
        Returns the results section: heading -> sentences.
    sections : tuple of callable
        Each returns a report section, given the analysis and the figures (name -> SVG).
    figures : callable
        Returns the figures, keyed by file name.
    tables : callable
        Returns the tables, keyed by file name.
    session_tables : callable
        Returns the session measures of each participant.
    package, version : str
        The package that provides it; empty for Slipscale.
    """

    name: str
    trials: TaskTrials | None = None
    statistics: tuple[Statistic[object], ...] = ()
    questions: Callable[[Analysis], list[str]] = _nothing_to_say
    design: Callable[[Analysis], list[str]] = _nothing_to_say
    answers: Callable[[Analysis], list[str]] = _nothing_to_say
    doubts: Callable[[Analysis], list[str]] = _nothing_to_say
    sentences: Callable[[Analysis], Mapping[str, list[str]]] = _nothing_titled
    sections: tuple[SectionWriter, ...] = ()
    figures: Callable[[Analysis], Mapping[str, Figure]] = _no_figures
    tables: Callable[[Analysis], Mapping[str, pd.DataFrame]] = _no_tables
    session_tables: Callable[[Dataset, Prepared | None], Iterable[SessionTable]] = _no_sessions
    package: str = ""
    version: str = ""

    def __reduce__(self) -> tuple[Callable[[str], object], tuple[str]]:
        """Pickle the declaration as its name, because its functions cannot be pickled."""
        return _kind_named, (self.name,)


def _kind_named(name: str) -> object:
    # Looked up by name when unpickling, because the declarations import this module.
    table = import_module("slipscale.analysis.tasks.outside.guard")
    return next(kind for kind in table.every_kind() if kind.name == name)


DeviationKind = Literal[
    "bundle",
    "study",
    "data",
    "participants",
    "dates",
    "exclusions",
    "normalisation",
    "tests",
    "options",
    "versions",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Deviation:
    """One deviation from the plan.

    Parameters
    ----------
    kind : str
        What the deviation concerns.
    what : str
        One sentence: what was planned, and what was done.
    """

    kind: DeviationKind
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanCheck:
    """An analysis compared with its plan.

    Parameters
    ----------
    plan : str
        Name of the bundle.
    frozen_utc : str
        Time at which the plan was frozen, according to the plan.
    digest : str
        SHA-256 of the plan, as printed on its page.
    deviations : tuple of Deviation
        Deviations; empty if the analysis follows the plan.
    """

    plan: str
    frozen_utc: str
    digest: str
    deviations: tuple[Deviation, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """Everything that `slipscale.analysis.pipeline.analyse` computes.

    Parameters
    ----------
    dataset : Dataset
        The analysed data: as read, minus the excluded participants.
    rule : str
        The normalisation rule, a key of `slipscale.analysis.preprocessing.normalisation.RULES`.
    estimates : DataFrame
        Analysed trials with their ``normalised`` estimate, ``log``, ``position``, ``repetition``.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    table3, description : DataFrame
        See `slipscale.analysis.statistics.descriptives`.
    textures : DataFrame
        See `slipscale.analysis.tasks.estimation.textures.describe`.
    prepared : Prepared or None
        Input to the tests; None without magnitude estimates.
    inference : Inference
        One field per test, see `slipscale.analysis.tasks.table`.
    sensitivity : tuple of RuleSummary
        Means and standard deviations under every normalisation rule.
    robustness : tuple of SubsetSummary
        The main results with and without flagged participants.
    individuals : DataFrame
        See `slipscale.analysis.reporting.individuals`.
    measures, flags : DataFrame
        Data quality of every participant, including excluded ones; see
        `slipscale.analysis.preprocessing.data_quality`.
    excluded : Mapping
        Participant -> the flags that excluded them.
    friction : MeasuredFriction or None
        Ratings against measured friction; None if none was measured.
    kinds : tuple of TaskAnalysis
        Slipscale's kinds of task, then those of other packages, in the order of the report.
    plan : PlanCheck or None
        Deviations from a frozen plan; None without a plan.
    problems : tuple of str
        Errors in the data, and results that could not be computed, one sentence each.
    """

    dataset: Dataset
    rule: str
    estimates: pd.DataFrame
    cells: pd.DataFrame
    table3: pd.DataFrame
    description: pd.DataFrame
    textures: pd.DataFrame
    prepared: Prepared | None
    inference: Inference
    sensitivity: tuple[RuleSummary, ...]
    robustness: tuple[SubsetSummary, ...]
    individuals: pd.DataFrame
    measures: pd.DataFrame
    flags: pd.DataFrame
    excluded: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    friction: MeasuredFriction | None = None
    kinds: tuple[TaskAnalysis, ...] = ()
    plan: PlanCheck | None = None
    problems: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return a few lines: participants, trials, normalisation, first conclusions."""
        return str(self._displays().text(self))

    def _repr_html_(self) -> str:
        """Return the same text with Table III and the figure, for notebooks."""
        return str(self._displays().html(self))

    def _displays(self) -> ModuleType:
        # Imported when displayed, because the reports import this module.
        return import_module("slipscale.analysis.reporting.notebook")
