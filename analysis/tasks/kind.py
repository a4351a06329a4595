"""Define the result of an analysis, and the declaration of a kind of task.

Each kind of task has a folder in `slipscale.analysis.tasks` or `slipscale.analysis.tasks.effects`,
and corresponds to a `Protocol` of the session. The module ``declaration`` in this folder derives a
class from `TaskAnalysis`, which defines everything that the report and its files show about the
kind of task; `slipscale.analysis.tasks.table` lists the declarations. Other packages declare kinds
of task with an entry point; see `slipscale.analysis.tasks.outside`.

Shared code (loading, inference, page, files, plans) loops over `Analysis.kinds` and does not refer
to specific kinds. All methods of a declaration, except ``session_tables``, receive the whole
`Analysis`, and all return an empty result if there are no trials.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from slipscale.analysis.preprocessing.normalisation import RULES
from slipscale.analysis.published import biet2007
from slipscale.analysis.statistics.statistic import Declaration

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


class TaskAnalysis(Declaration):
    """The declaration of a kind of task, as the base class of all kinds of task.

    Every method returns an empty result unless a kind of task overrides it.

    Attributes
    ----------
    name : str
        Name of the folder that contains the declaration, or of the entry point in another package.
    trials : TaskTrials or None
        Description of the tables that contain the trials, and of how to read them.
    statistics : tuple of Statistic
        Statistics, in the order in which they are computed and written to ``inference.json``.
    package, version : str
        Name and version of the package that provides this kind of task. Empty for Slipscale's own
        kinds of task.
    """

    name: str
    trials: TaskTrials | None = None
    statistics: tuple[Statistic[object], ...] = ()
    package: str = ""
    version: str = ""

    def questions(self, _analysis: Analysis, /) -> list[str]:
        """Return the research questions with which the summary begins."""
        return []

    def design(self, _analysis: Analysis, /) -> list[str]:
        """Return descriptions of the design, such as the numbers of trials and surfaces."""
        return []

    def answers(self, _analysis: Analysis, /) -> list[str]:
        """Return the sentences for the summary."""
        return []

    def plain_answers(self, analysis: Analysis, /) -> list[str]:
        """Return the sentences with which the report begins (default: the first of ``answers``).

        They are followed by a figure; the other sentences follow the figure.
        """
        return self.answers(analysis)[:1]

    def doubts(self, _analysis: Analysis, /) -> list[str]:
        """Return the caveats for the summary."""
        return []

    def sentences(self, _analysis: Analysis, /) -> Mapping[str, list[str]]:
        """Return the sentences for the results section, keyed by heading."""
        return {}

    def sections(self, _analysis: Analysis, _svgs: Mapping[str, str]) -> Iterable[ReportSection]:
        """Return the sections of the report, given the figures (SVG text, keyed by name)."""
        return ()

    def figures(self, _analysis: Analysis, /) -> Mapping[str, Figure]:
        """Return the figures, keyed by file name."""
        return {}

    def tables(self, _analysis: Analysis, /) -> Mapping[str, pd.DataFrame]:
        """Return the tables, keyed by file name."""
        return {}

    def session_tables(self, _data: Dataset, _prepared: Prepared | None) -> Iterable[SessionTable]:
        """Return tables of measures, with one row per participant and one column per session."""
        return ()


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


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
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

    @property
    def beside_paper(self) -> bool:
        """Whether results are shown next to the paper's: its study, its amplitudes, its scale."""
        return (
            self.dataset.details.get("study") == (biet2007.STUDY,)
            and RULES[self.rule].end == biet2007.TOP
            and biet2007.covers(self.table3["level"], self.dataset.quantity)
        )
