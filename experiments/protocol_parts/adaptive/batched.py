"""Many simultaneous QUEST+ runs for simulations, using one matrix product per trial.

Given the same answers, each run selects the same levels as a `QuestPlusTrack`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from slipscale.experiments.protocol_parts.adaptive.curves import Array
from slipscale.experiments.protocol_parts.adaptive.quest_plus import QuestPlus, information_gain
from slipscale.experiments.steps.rounding import DECIMALS
from slipscale.faults import UserError

#: Maximum number of runs times parameter combinations, whose posteriors take 400 MB.
LARGEST_BATCH = 50_000_000


@dataclass(frozen=True, eq=False, kw_only=True)
class QuestPlusBatch:
    """The state of many simultaneous QUEST+ runs.

    Parameters
    ----------
    rule : QuestPlus
        Grids of levels and parameters, shared by all runs.
    posteriors : array, shape (runs, combinations)
        Posterior weights; each row sums to 1.
    trials : int
        Number of answers so far in each run.
    """

    rule: QuestPlus
    posteriors: Array
    trials: int = 0

    @classmethod
    def start(cls, rule: QuestPlus, runs: int) -> Self:
        """Return the initial state of ``runs`` simultaneous runs, before any trial.

        Raises
        ------
        UserError
            If ``runs`` is below 1, or the runs do not fit in memory.
        """
        if runs < 1:
            raise UserError("QUEST+: {runs} runs, expected 1 or more", runs=runs)
        if runs * rule.prior.size > LARGEST_BATCH:
            raise UserError(
                "QUEST+: {runs} runs of {combinations} combinations of parameters do not fit in"
                " memory, expected at most {largest_batch} runs at once",
                runs=runs,
                combinations=rule.prior.size,
                largest_batch=LARGEST_BATCH // rule.prior.size,
            )
        return cls(rule=rule, posteriors=np.tile(rule.prior, (runs, 1)))

    @cached_property
    def level_indices(self) -> npt.NDArray[np.intp]:
        """Index of each run's next level, shape (runs,)."""
        return np.asarray(np.argmax(information_gain(self.rule, self.posteriors), axis=1))

    @property
    def levels(self) -> Array:
        """Level of each run's next trial, in µm peak to peak, shape (runs,)."""
        return np.round(np.array(self.rule.levels)[self.level_indices], DECIMALS)

    def answered(self, correct: npt.NDArray[np.bool_]) -> Self:
        """Return the state updated with one answer per run; ``correct`` has shape (runs,)."""
        posteriors = self.rule.likelihood[correct.astype(int), self.level_indices]
        posteriors *= self.posteriors
        totals = posteriors @ np.ones((self.rule.prior.size, 1))
        if not np.all(totals > 0):
            raise UserError(
                "QUEST+: one of the answers has probability 0 for every combination of parameters"
            )
        posteriors /= totals
        return type(self)(rule=self.rule, posteriors=posteriors, trials=self.trials + 1)

    @property
    def threshold_log10(self) -> Array:
        """Posterior mean of log10(threshold in µm peak to peak) for each run, shape (runs,)."""
        return np.asarray(self.posteriors @ self.rule.log10_thresholds)
