"""Define the result of an analysis, and the declaration of a kind of task.

Each kind of task has a folder in `slipscale.analysis.tasks` or `slipscale.analysis.tasks.effects`,
and corresponds to a `Protocol` of the session. The module ``declaration`` in this folder defines
everything that the report and its files show about the kind of task;
`slipscale.analysis.tasks.table` lists the declarations. Other packages declare kinds of task with
an entry point; see `slipscale.analysis.tasks.outside`.

Shared code (loading, inference, page, files, plans) loops over `Analysis.kinds` and does not refer
to specific kinds. All functions in a declaration, except ``session_tables``, receive the whole
`Analysis`, and all return an empty result if there are no trials.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
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

SectionWriter = Callable[["Analysis", Mapping[str, str]], "ReportSection"]


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
    """The declaration of a kind of task.

    Parameters
    ----------
    name : str
        Name of the folder that contains the declaration, or of the entry point in another package.
    trials : TaskTrials, optional
        Description of the tables that contain the trials, and of how to read them.
    statistics : tuple of Statistic
        Statistics, in the order in which they are computed and written to ``inference.json``.
    questions : callable
        Returns the research questions with which the summary begins.
    design : callable
        Returns descriptions of the design, such as the numbers of trials and surfaces.
    answers : callable
        Returns the sentences for the summary.
    doubts : callable
        Returns the caveats for the summary.
    sentences : callable
        Returns the sentences for the results section, keyed by heading.
    sections : tuple of callable
        Functions that each return a report section, given the analysis and the figures (SVG text,
        keyed by name).
    figures : callable
        Returns the figures, keyed by file name.
    tables : callable
        Returns the tables, keyed by file name.
    session_tables : callable
        Returns tables of measures, with one row per participant and one column per session.
    package, version : str
        Name and version of the package that provides this kind of task. Empty for Slipscale's own
        kinds of task.
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
        """Pickle only the name, because the functions of a declaration cannot be pickled."""
        return _kind_named, (self.name,)


def _kind_named(name: str) -> object:
    # Imported when unpickling, because the declarations import this module.
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
    """A deviation from the plan.

    Parameters
    ----------
    kind : str
        What the deviation concerns.
    what : str
        A sentence that compares the plan with the data or analysis.
    """

    kind: DeviationKind
    what: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanCheck:
    """The comparison of an analysis with its plan.

    Parameters
    ----------
    plan : str
        Name of the bundle that contains the plan.
    frozen_utc : str
        Time at which the plan was frozen, as recorded in the plan.
    digest : str
        SHA-256 digest of the plan, as printed on the plan's page.
    deviations : tuple of Deviation
        Deviations from the plan. Empty if the analysis follows the plan.
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
        Data set without excluded participants.
    rule : str
        Normalisation rule, a key of `slipscale.analysis.preprocessing.normalisation.RULES`.
    estimates : DataFrame
        Analysed trials, with the additional columns ``normalised``, ``log``, ``position`` and
        ``repetition``.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    table3, description : DataFrame
        See `slipscale.analysis.statistics.descriptives`.
    textures : DataFrame
        See `slipscale.analysis.tasks.estimation.textures.describe`.
    prepared : Prepared or None
        Estimates prepared for inference; None without magnitude estimates.
    inference : Inference
        Results of all statistics; see `slipscale.analysis.tasks.table`.
    sensitivity : tuple of RuleSummary
        Means and standard deviations under all applicable normalisation rules.
    robustness : tuple of SubsetSummary
        Main results with and without flagged participants.
    individuals : DataFrame
        See `slipscale.analysis.reporting.individuals`.
    measures, flags : DataFrame
        Data quality of all participants, including excluded participants; see
        `slipscale.analysis.preprocessing.data_quality`.
    excluded : Mapping
        Reasons for exclusion, by participant.
    friction : MeasuredFriction or None
        Relation between ratings and friction; None if friction was not measured.
    kinds : tuple of TaskAnalysis
        Slipscale's kinds of task, followed by those from other packages, in the order of the
        report.
    plan : PlanCheck or None
        Deviations from a frozen plan; None without a plan.
    problems : tuple of str
        Sentences on errors in the data and on results that could not be computed.
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
        """Return a short summary in plain text."""
        return str(self._displays().text(self))

    def _repr_html_(self) -> str:
        """Return an HTML summary for notebooks."""
        return str(self._displays().html(self))

    def _displays(self) -> ModuleType:
        # Imported when needed, because the module for reports imports this module.
        return import_module("slipscale.analysis.reporting.notebook")
