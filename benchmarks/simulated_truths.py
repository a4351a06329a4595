"""Compute the true values of simulated people without a protocol or an analysis.

Simulated people choose the surface with the largest impression: the population's mean sensation
plus normally distributed noise, whose standard deviation differs between people; see
`slipscale.experiments.participants.simulated_people.respondent`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import integrate, optimize, stats

from slipscale.experiments.participants.simulated_people.population import Population, curves
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: Number of simulated people or answers over which expected proportions are averaged.
MANY = 200_000
#: Derivative of a Weibull function with slope 1, by the logarithm of the level, at one half.
WEIBULL_DENSITY = math.log(2) / 2


class Threshold(NamedTuple):
    """A person's level half-way between guessing and the best performance, and the slope there."""

    track_level: float
    slope: float


def own_noise(people: Population, seed: int, label: str) -> float:
    """Return the change in sensation that gives d' = 1 for a person of a data set."""
    deviate = Stream(seed, label, "simulated", "threshold").normal()
    return people.noise * math.exp(people.threshold_sigma * deviate)


def share_found(change: float, intervals: int) -> float:
    """Return how often a change in sensation is detected, corrected for guessing: from 0 to 1.

    The change is in standard deviations of the difference between two impressions.
    """
    if intervals == 2:
        right = float(stats.norm.cdf(change))
    else:
        d_prime = change * math.sqrt(2)
        right, _ = integrate.quad(
            lambda z: stats.norm.pdf(z - d_prime) * stats.norm.cdf(z) ** (intervals - 1), -8, 12
        )
    return (right - 1 / intervals) / (1 - 1 / intervals)


@lru_cache
def _half_way(intervals: int) -> tuple[float, float]:
    """Return the change for which `share_found` is 0.5, and the slope there."""
    half = optimize.brentq(lambda change: share_found(change, intervals) - 0.5, 0, 5)
    rise = (share_found(half + 0.01, intervals) - share_found(half - 0.01, intervals)) / 0.02
    return half, rise


def forced_choice(
    people: Population, noise: float, standard_level: float, intervals: int
) -> Threshold:
    """Return the difference for which `share_found` is 0.5, and the Weibull function's slope."""
    mean = curves(people).mean
    half, rise = _half_way(intervals)
    start = mean(standard_level)
    top = people.levels[-1] - standard_level
    level = optimize.brentq(
        lambda more: (mean(standard_level + more) - start) / noise - half, 1e-6, top
    )
    steepness = (mean(standard_level + 1.01 * level) - mean(standard_level + 0.99 * level)) / noise
    return Threshold(level, rise * steepness / 0.02 / WEIBULL_DENSITY)


def comparison(people: Population, noise: float, standard_level: float) -> Threshold:
    """Return half the distance between the quartiles, and the slope at the standard."""
    mean = curves(people).mean
    start = mean(standard_level)
    ends = [
        optimize.brentq(
            lambda more, z=z: (mean(standard_level + more) - start) / noise - z, -0.6, 0.6
        )
        for z in stats.norm.ppf([0.25, 0.75])
    ]
    slope = (mean(standard_level + 0.001) - mean(standard_level - 0.001)) / 0.002 / noise
    return Threshold((ends[1] - ends[0]) / 2, slope)


def chosen_over(people: Population, surfaces_level: Sequence[float]) -> Array:
    """Return how often the population chooses the row's surface over the column's."""
    noise = _noises(people)
    seemed = np.array([curves(people).mean(each) for each in surfaces_level])
    apart = seemed[:, None] - seemed[None, :]
    share = stats.norm.cdf(apart[:, :, None] / noise).mean(axis=2)
    lapses = people.habits.lapses
    return np.asarray((1 - lapses) * share + lapses / 2)


def second_step_larger(
    people: Population, surfaces_level: Sequence[float]
) -> dict[tuple[int, int, int], float]:
    """Return how often the second step in a triad is judged larger, keyed by the triad."""
    rng = np.random.default_rng(1)
    each = _noises(people) / math.sqrt(2)
    mean = [curves(people).mean(surface) for surface in surfaces_level]
    found = {}
    for triad in combinations(range(len(mean)), 3):
        first, second, third = (mean[place] + each * rng.standard_normal(MANY) for place in triad)
        larger = np.mean(np.abs(third - second) > np.abs(second - first))
        lapses = people.habits.lapses
        found[triad] = float((1 - lapses) * larger + lapses / 2)
    return found


def matched(
    people: Population, reference_level: float, *, sign: int, nearest: float, furthest: float
) -> float:
    """Return the mean amplitude at which adjustment from below (1) or above (-1) stops."""
    rng = np.random.default_rng(2)
    noise = _noises(people)
    table = np.arange(0, 2.31, 0.01)
    mean = np.array([curves(people).mean(float(each)) for each in table])
    at = reference_level - sign * rng.uniform(nearest, furthest, MANY)
    target = mean[round(100 * reference_level)]
    seems = _seeming(mean, noise, rng)
    way = np.where(seems(at) < target, 1, -1)
    going = np.ones(MANY, dtype=bool)
    for _ in range(150):
        at[going] = np.clip(at + 0.02 * way, 0, 2.3)[going]
        reached = way * (seems(at) - target) >= 0
        going &= ~reached
    return float(at.mean())


def _seeming(mean: Array, noise: Array, rng: np.random.Generator) -> Callable[[Array], Array]:
    def seems(at_level: Array) -> Array:
        felt = np.round(100 * at_level).astype(int)
        return np.asarray(mean[felt] + noise * rng.standard_normal(len(at_level)))

    return seems


def _noises(people: Population) -> Array:
    """Draw the noise (standard deviation of a difference) of many people."""
    deviates = np.random.default_rng(3).standard_normal(MANY)
    return np.asarray(people.noise * np.exp(people.threshold_sigma * deviates))
