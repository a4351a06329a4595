"""QUEST+: present the level at which the next answer is expected to be most informative.

See Watson 2017, Journal of Vision 17(3):10, doi:10.1167/17.3.10. The expected decrease in the
posterior's entropy is the mutual information between answer and parameters: the entropy of the
predicted answer, minus the mean entropy of the answer given the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np

from slipscale.experiments.protocol_parts.adaptive.curves import CURVES, Array
from slipscale.experiments.protocol_parts.adaptive.track import Progress, check_between
from slipscale.experiments.steps.rounding import DECIMALS, rounded
from slipscale.faults import UserError

#: Maximum number of levels times parameter combinations. A grid of this size has four tables that
#: take 64 MB in total. Reading two of these tables in each trial takes 0.37 of a frame at 60 Hz.
LARGEST_GRID = 2_000_000
#: An observer with a larger lapse rate is not performing the task.
LARGEST_LAPSE = 0.5


def entropy(share: Array) -> Array:
    """Return the entropy of a binary answer with probability ``share``, in nats."""
    with np.errstate(divide="ignore", invalid="ignore"):
        terms = share * np.log(share) + (1 - share) * np.log1p(-share)
    return np.where((share > 0) & (share < 1), -terms, 0.0)


@dataclass(frozen=True, kw_only=True)
class QuestPlus:
    """A QUEST+ rule: the available levels, and a grid of psychometric functions.

    Parameters
    ----------
    levels : tuple of float
        Levels that can be presented, in µm peak to peak and in ascending order.
    threshold_levels, slopes, lapses : tuple of float
        Ascending parameter grids of the psychometric functions (`curves.Curve`); thresholds are in
        µm peak to peak.
    guess : float
        Proportion correct by guessing.
    curve : str
        A key of `curves.CURVES`.
    threshold_weights : tuple of float
        Unnormalised prior weights of the thresholds; if empty, all weights are equal.

    Raises
    ------
    UserError
        If a grid is empty, not ascending, out of range or too large, or if the prior has the wrong
        length.
    """

    levels: tuple[float, ...]
    threshold_levels: tuple[float, ...]
    slopes: tuple[float, ...]
    lapses: tuple[float, ...] = (0.02,)
    guess: float = 0.5
    curve: str = "weibull"
    threshold_weights: tuple[float, ...] = field(default=())

    def __post_init__(self) -> None:
        if self.curve not in CURVES:
            raise UserError(
                "QUEST+: curve is {curve}, expected one of {curves}",
                curve=repr(self.curve),
                curves=", ".join(CURVES),
            )
        tiny = float(np.finfo(float).tiny)
        _check_grid("levels", self.levels, lowest=0.0)
        _check_grid("thresholds", self.threshold_levels, lowest=tiny)
        _check_grid("slopes", self.slopes, lowest=tiny)
        _check_grid("lapses", self.lapses, lowest=0.0)
        check_between("QUEST+", "the largest lapse", self.lapses[-1], 0.0, LARGEST_LAPSE)
        check_between("QUEST+", "guess", self.guess, 0.0, 1.0 - self.lapses[-1])
        if len({rounded(level) for level in self.levels}) < len(self.levels):
            raise UserError(
                "QUEST+: two levels are the same at {decimals} decimals", decimals=DECIMALS
            )
        weights = self.threshold_weights
        if weights and len(weights) != len(self.threshold_levels):
            raise UserError(
                "QUEST+: {weights} threshold_weights for {thresholds} thresholds, expected equal "
                "numbers",
                weights=len(weights),
                thresholds=len(self.threshold_levels),
            )
        if weights and not (np.isfinite(weights).all() and min(weights) >= 0 and max(weights) > 0):
            raise UserError(
                "QUEST+: threshold_weights must all be 0 or more, and at least one weight must "
                "be above 0"
            )
        cells = len(self.levels) * int(np.prod(self.shape))
        if cells > LARGEST_GRID:
            raise UserError(
                "QUEST+: {levels} levels times {combinations} combinations of parameters are "
                "{cells} cells, more than {largest_grid}; use coarser grids",
                levels=len(self.levels),
                combinations=cells // len(self.levels),
                cells=cells,
                largest_grid=LARGEST_GRID,
            )

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of thresholds, slopes and lapse rates on the grid."""
        return len(self.threshold_levels), len(self.slopes), len(self.lapses)

    @cached_property
    def prior(self) -> Array:
        """Prior weights of all parameter combinations, shape (combinations,), with sum 1."""
        weights = np.array(self.threshold_weights or (1.0,) * len(self.threshold_levels))
        prior = np.broadcast_to(weights[:, None, None], self.shape).flatten()
        return _frozen(prior / prior.sum())

    @cached_property
    def proportion(self) -> Array:
        """Proportion of correct answers, shape (levels, combinations)."""
        threshold, slope, lapse = np.meshgrid(
            self.threshold_levels, self.slopes, self.lapses, indexing="ij"
        )
        table = CURVES[self.curve].proportion(
            np.array(self.levels)[:, None],
            threshold_level=threshold.ravel(),
            slope=slope.ravel(),
            guess=self.guess,
            lapse=lapse.ravel(),
        )
        return _frozen(table)

    @cached_property
    def likelihood(self) -> Array:
        """Probability of a wrong (0) and a correct (1) answer, shape (2, levels, combinations)."""
        return _frozen(np.stack([1 - self.proportion, self.proportion]))

    @cached_property
    def answer_entropy(self) -> Array:
        """Entropy of the answer given the parameters, in nats, shape (levels, combinations)."""
        return _frozen(entropy(self.proportion))

    @cached_property
    def log10_thresholds(self) -> Array:
        """Log10(threshold in µm peak to peak) of each combination, shape (combinations,)."""
        decades = np.log10(self.threshold_levels)
        return _frozen(np.broadcast_to(decades[:, None, None], self.shape).flatten())

    def start(self) -> QuestPlusTrack:
        """Return a track in its initial state, before the first trial."""
        return QuestPlusTrack(rule=self, posterior=self.prior)


@dataclass(frozen=True, eq=False, kw_only=True)
class QuestPlusTrack:
    """A QUEST+ run.

    Parameters
    ----------
    rule : QuestPlus
        Grids of levels and parameters.
    posterior : array, shape (combinations,)
        Weights of the parameter combinations, with sum 1; read-only.
    trials : int
        Number of answers so far.
    """

    rule: QuestPlus
    posterior: Array
    trials: int = 0

    @cached_property
    def level_index(self) -> int:
        """Index of the most informative level (the first, if several are equally informative)."""
        return int(np.argmax(information_gain(self.rule, self.posterior[None, :])[0]))

    @property
    def level(self) -> float:
        """The level of the next trial, µm peak to peak."""
        return rounded(self.rule.levels[self.level_index])

    @property
    def progress(self) -> Progress:
        """Number of trials and posterior standard deviation of the threshold."""
        return Progress(trials=self.trials, threshold_sd_log10=self.threshold_sd_log10)

    @property
    def threshold_log10(self) -> float:
        """Posterior mean of log10(threshold in µm peak to peak)."""
        return float(self.posterior @ self.rule.log10_thresholds)

    @property
    def threshold_sd_log10(self) -> float:
        """Posterior standard deviation of the threshold, in decades."""
        squares = float(self.posterior @ (self.rule.log10_thresholds - self.threshold_log10) ** 2)
        return float(round(squares**0.5, DECIMALS))

    def answered(self, *, correct: bool, at_level: float | None = None) -> Self:
        """Return the track, updated with an answer at ``at_level`` (default: the next level)."""
        if at_level is None:
            return self.told(self.level_index, correct=correct)
        levels = [rounded(level) for level in self.rule.levels]
        return self.told(levels.index(at_level), correct=correct)

    def told(self, level_index: int, *, correct: bool) -> Self:
        """Return the track, updated with an answer at the level with the given index.

        Raises
        ------
        UserError
            If the answer has probability 0 for every combination of parameters on the grid.
        """
        posterior = self.posterior * self.rule.likelihood[int(correct), level_index]
        total = posterior.sum()
        if not total > 0:
            raise UserError(
                "QUEST+: no combination of parameters allows {answer} answer at {level:g}; allow "
                "lapses above 0",
                answer="a correct" if correct else "a wrong",
                level=self.rule.levels[level_index],
            )
        return type(self)(
            rule=self.rule, posterior=_frozen(posterior / total), trials=self.trials + 1
        )


def information_gain(rule: QuestPlus, posteriors: Array) -> Array:
    """Return the expected decrease in posterior entropy for each run and level.

    Parameters
    ----------
    posteriors : array, shape (runs, combinations)
        Each row sums to 1.

    Returns
    -------
    array, shape (runs, levels)
        Information in nats, rounded to `rounding.DECIMALS` decimals.
    """
    predicted = np.clip(posteriors @ rule.proportion.T, 0.0, 1.0)  # rounding may push a sum above 1
    return np.round(entropy(predicted) - posteriors @ rule.answer_entropy.T, DECIMALS)


def _frozen(array: Array) -> Array:
    array.flags.writeable = False
    return array


def _check_grid(name: str, values: Sequence[float], *, lowest: float) -> None:
    if not values:
        raise UserError("QUEST+: {name} is empty, expected at least one value", name=name)
    array = np.asarray(values, float)
    if not np.isfinite(array).all() or np.any(np.diff(array) <= 0):
        raise UserError("QUEST+: {name} must be finite and ascending", name=name)
    if array[0] < lowest:
        raise UserError(
            "QUEST+: {name} begins at {first:g}, expected {expected}",
            name=name,
            first=array[0],
            expected="0 or more" if lowest == 0 else "above 0",
        )
