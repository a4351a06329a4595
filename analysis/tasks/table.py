"""List the kinds of task in report order, and compute their statistics.

To add a kind of task, create a folder with its declaration, and list the declaration in `KINDS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inference, Inputs, SessionTable
from slipscale.analysis.tasks.difference import declaration as difference
from slipscale.analysis.tasks.effects.factors import declaration as factors
from slipscale.analysis.tasks.effects.friction import declaration as friction
from slipscale.analysis.tasks.effects.groups import declaration as groups
from slipscale.analysis.tasks.effects.sessions import declaration as sessions
from slipscale.analysis.tasks.estimation import declaration as estimation
from slipscale.analysis.tasks.exponent_and_weber import declaration as exponent_and_weber
from slipscale.analysis.tasks.identification import declaration as identification
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.limits import declaration as limits
from slipscale.analysis.tasks.matching import declaration as matching
from slipscale.analysis.tasks.pointing import declaration as pointing
from slipscale.analysis.tasks.productions import declaration as productions
from slipscale.analysis.tasks.ratings import declaration as ratings
from slipscale.analysis.tasks.ratios import declaration as ratios
from slipscale.analysis.tasks.same_different import declaration as same_different
from slipscale.analysis.tasks.scales import declaration as scales
from slipscale.analysis.tasks.similarity import declaration as similarity
from slipscale.analysis.tasks.similarity.sorting import declaration as sorting
from slipscale.analysis.tasks.thresholds import declaration as thresholds
from slipscale.experiments.study.analysis_choices import Test

KINDS: tuple[TaskAnalysis, ...] = (
    estimation.ANALYSIS,
    sessions.ANALYSIS,
    groups.ANALYSIS,
    factors.ANALYSIS,
    friction.ANALYSIS,
    difference.ANALYSIS,
    thresholds.ANALYSIS,
    exponent_and_weber.ANALYSIS,
    scales.ANALYSIS,
    matching.ANALYSIS,
    ratings.ANALYSIS,
    ratios.ANALYSIS,
    productions.ANALYSIS,
    similarity.ANALYSIS,
    sorting.ANALYSIS,
    same_different.ANALYSIS,
    limits.ANALYSIS,
    identification.ANALYSIS,
    pointing.ANALYSIS,
)
#: Statistics in the order of ``inference.json``. A statistic may use the results of earlier ones.
STATISTICS = tuple(statistic for kind in KINDS for statistic in kind.statistics)
#: Kinds for which studies can choose the task label, in the order in which their tables are
#: recognised.
TRIALS = tuple(kind.trials for kind in KINDS if kind.trials is not None)


def conclude(
    data: Dataset,
    prepared: Prepared | None,
    rule: str | None,
    *,
    bayesian: bool = False,
    kinds: Sequence[TaskAnalysis] | None = None,
) -> Inference:
    """Compute all mandatory statistics, and the optional statistics selected in the study file.

    Parameters
    ----------
    kinds : sequence of TaskAnalysis, optional
        Kinds of task to analyse. The default is `KINDS`, without kinds of task from other packages.
    data, prepared, rule, bayesian : object
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
