"""Compute all statistics for all kinds of task."""

from __future__ import annotations

from typing import TYPE_CHECKING, get_args

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inference, Inputs
from slipscale.analysis.tasks.table import KINDS
from slipscale.experiments.study.analysis_choices import Test

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.statistic import SessionTable
    from slipscale.analysis.tasks.kind import TaskAnalysis


def conclude(
    data: Dataset,
    prepared: Prepared | None,
    rule: str | None,
    *,
    bayesian: bool = False,
    kinds: Sequence[TaskAnalysis] | None = None,
) -> Inference:
    """Compute every statistic that the study chose, and the mandatory ones.

    Parameters
    ----------
    kinds : sequence of TaskAnalysis, optional
        Default: all of Slipscale's kinds.
    data, prepared, rule, bayesian
        See `slipscale.analysis.statistics.statistic.Inputs`.
    """

    def session_tables() -> list[SessionTable]:
        return [table for kind in every for table in kind.session_tables(data, prepared)]

    every = KINDS if kinds is None else kinds
    chosen = data.choices.tests
    left_out = set() if chosen is None else set(get_args(Test)) - set(chosen)
    found = Inference()
    for statistic in [each for kind in every for each in kind.statistics]:
        if statistic.key in left_out:
            result: object = NotComputed("not chosen in the study file")
        else:
            result = statistic.compute(
                Inputs(
                    data=data,
                    prepared=prepared,
                    rule=rule,
                    bayesian=bayesian,
                    session_tables=session_tables,
                    found=found,
                )
            )
        found = found.with_result(statistic, result)
    return found
