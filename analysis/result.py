"""The result of an analysis: one frozen structure that tables, figures and pages are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from types import ModuleType

    import pandas as pd

    from slipscale.analysis.own.declaration import OwnFinding
    from slipscale.analysis.plan_check import PlanCheck
    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.measured_friction import MeasuredFriction
    from slipscale.analysis.statistics.robustness import SubsetSummary
    from slipscale.analysis.statistics.sensitivity import RuleSummary
    from slipscale.analysis.statistics.statistic import Inference


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """Everything that `slipscale.analysis.pipeline.analyse` computes.

    Parameters
    ----------
    dataset : Dataset
        What was analysed: as read, less the participants excluded.
    rule : str
        The normalisation, a key of `slipscale.analysis.preprocessing.normalisation.RULES`.
    estimates : DataFrame
        Analysed trials with their ``normalised`` estimate, ``log``, ``position``, ``repetition``.
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean normalised estimates.
    table3, description : DataFrame
        See `slipscale.analysis.statistics.descriptives`.
    textures : DataFrame
        See `slipscale.analysis.tasks.estimation.textures.describe`.
    prepared : Prepared or None
        What the tests were computed from; None where there are no magnitude estimates.
    inference : Inference
        One field a test, see `slipscale.analysis.tasks.run`.
    sensitivity : tuple of RuleSummary
        Means and spreads under every normalisation.
    robustness : tuple of SubsetSummary
        The chief results with and without flagged participants.
    individuals : DataFrame
        See `slipscale.analysis.tasks.individuals`.
    measures, flags : DataFrame
        Data quality of every participant read, see `slipscale.analysis.preprocessing.data_quality`.
    excluded : Mapping
        Participant -> the flags that excluded them.
    friction : MeasuredFriction or None
        Ratings against measured friction; None where none was measured.
    own : tuple of OwnFinding
        What outside analyses found, by name.
    plan : PlanCheck or None
        What is otherwise than in a frozen plan; None where there is none to be held against.
    problems : tuple of str
        What was wrong with the data or could not be computed, one sentence each.
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
    own: tuple[OwnFinding, ...] = ()
    plan: PlanCheck | None = None
    problems: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return a few lines: participants, trials, normalisation, first conclusions."""
        return str(self._displays().text(self))

    def _repr_html_(self) -> str:
        """Return the same with Table III and the figure, for notebooks."""
        return str(self._displays().html(self))

    def _displays(self) -> ModuleType:
        # By name, when displayed: the reports import this module.
        return import_module("slipscale.analysis.reporting.notebook")
