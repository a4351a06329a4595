"""Compute every statistic of every kind of task."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inference, Inputs
from slipscale.analysis.tasks.table import KINDS, STATISTICS

if TYPE_CHECKING:
    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.statistic import SessionTable


def conclude(
    data: Dataset,
    prepared: Prepared | None,
    rule: str | None,
    *,
    bayesian: bool = False,
    psignifit: bool = True,
) -> Inference:
    """Compute every statistic that the study chose.

    Parameters
    ----------
    data, prepared, rule, bayesian, psignifit
        See `slipscale.analysis.statistics.statistic.Inputs`.
    """

    def session_tables() -> list[SessionTable]:
        return [table for kind in KINDS for table in kind.session_tables(data, prepared)]

    chosen = data.choices.tests
    found = Inference()
    for statistic in STATISTICS:
        if statistic.test and chosen is not None and statistic.key not in chosen:
            result: object = NotComputed("not chosen in the study file")
        else:
            result = statistic.compute(
                Inputs(
                    data=data,
                    prepared=prepared,
                    rule=rule,
                    bayesian=bayesian,
                    psignifit=psignifit,
                    session_tables=session_tables,
                    found=found,
                )
            )
        found = found.with_result(statistic.key, result)
    return found
