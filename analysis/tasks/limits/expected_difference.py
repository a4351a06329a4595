"""Compute the difference between descending and ascending series that noise alone causes.

A series ends at the first changed answer. A noisy participant gives the first "felt" of an
ascending series below their threshold on average, and the first "not felt" of a descending series
above it. Without anticipation or habituation, descending series thus end higher: by 0.0, 0.5, 1.3
and 3.9 steps if sensations have a standard deviation of 0.4, 1, 1.6 and 3 steps. A test against a
difference of 0 was significant in .09, .3, .9 and 1.0 of such studies (8 people, 6 series).

The expected difference comes from cumulative normal functions with a threshold per participant and
a common spread, fitted to all answers by maximum likelihood. The rule by which series end depends
on answers only, so that it does not bias the likelihood. There is no parameter for a difference
between directions: with one, the spread is too small with few series, and differences that noise
explains are significant in up to .34 of studies; without one, in .00 to .08.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array

#: Smallest and largest spread, in distances between neighbouring levels.
SPREADS = (0.05, 50.0)
#: Levels that agree in so many decimals are equal.
DECIMALS = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class Series:
    """A series of answers.

    Parameters
    ----------
    who : int
        Index of the participant, from 0.
    rising : bool
        Whether levels ascend.
    levels, felt : array, shape (answers,)
    """

    who: int
    rising: bool
    levels: Array
    felt: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseAlone:
    """The common spread of sensations, and the differences that it causes.

    Parameters
    ----------
    spread_level : float
    difference_level : array, shape (participants,)
        Expected descending minus ascending transition; NaN without series in both directions.
    """

    spread_level: float
    difference_level: Array


def noise_alone(series: list[Series], people: int) -> NoiseAlone:
    """Return the differences between directions that noise alone causes."""
    # Sums of steps differ in the last bits.
    grid = np.unique(np.concatenate([each.levels for each in series]).round(DECIMALS))
    thresholds, spread = _fitted(series, people, float(np.diff(grid).min()) if len(grid) > 1 else 1)
    ends: list[dict[bool, list[float]]] = [{True: [], False: []} for _ in range(people)]
    for each in series:
        first = round(float(each.levels[0]), DECIMALS)
        after = grid >= first if each.rising else grid <= first
        levels = grid[after] if each.rising else grid[after][::-1]
        if len(levels) > 1:
            end = expected_transition(levels, thresholds[each.who], spread, rising=each.rising)
            ends[each.who][each.rising].append(end)
    return NoiseAlone(
        spread_level=spread,
        difference_level=np.array(
            [
                np.mean(own[False]) - np.mean(own[True]) if own[False] and own[True] else np.nan
                for own in ends
            ]
        ),
    )


def expected_transition(levels: Array, threshold: float, spread: float, *, rising: bool) -> float:
    """Return the mean transition of a series, given that the series has one.

    Parameters
    ----------
    levels : array, shape (levels,)
        Levels in order of presentation, at which the series would continue.
    threshold, spread : float
        Mean and standard deviation of the participant's cumulative normal function.
    """
    from scipy import special

    felt = special.ndtr((levels - threshold) / spread)
    ends = felt if rising else 1 - felt
    here = np.cumprod(np.append(1.0, 1 - ends[:-1])) * ends
    # The first answer has no earlier one from which it could differ.
    return float(np.average((levels[1:] + levels[:-1]) / 2, weights=np.maximum(here[1:], 1e-300)))


def _fitted(series: list[Series], people: int, step: float) -> tuple[Array, float]:
    from scipy import optimize, special

    level = np.concatenate([each.levels for each in series])
    sign = np.where(np.concatenate([each.felt for each in series]) > 0, 1.0, -1.0)
    who: NDArray[np.intp] = np.repeat(
        [each.who for each in series], [len(each.levels) for each in series]
    )

    def minus_log(at: Array) -> tuple[float, Array]:
        spread = np.exp(at[-1])
        z = (level - at[who]) / spread
        logs = special.log_ndtr(sign * z)
        pull = sign * np.exp(-(z**2) / 2 - 0.5 * np.log(2 * np.pi) - logs)
        by_person = -np.bincount(who, pull, people) / spread
        return -float(logs.sum()), -np.append(by_person, -(pull * z).sum())

    last = np.array([each.levels[-1] for each in series])
    owner = np.array([each.who for each in series])
    start = np.bincount(owner, last, people) / np.bincount(owner, minlength=people)
    low, high = np.log(step * np.array(SPREADS))
    found = optimize.minimize(
        minus_log,
        np.append(start, np.log(step)),
        jac=True,
        method="L-BFGS-B",
        bounds=[(float(level.min()), float(level.max()))] * people + [(float(low), float(high))],
    )
    return np.asarray(found.x[:-1], np.float64), float(np.exp(found.x[-1]))
