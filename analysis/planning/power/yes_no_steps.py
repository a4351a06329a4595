"""Simulate the descending difference task, and the precision that its catch steps provide.

Answers follow the model in `Respondent.notices`, applied to whole arrays. Intervals for the
proportion of "yes" at catch steps are computed as in the report. Because the probit model for d'
takes a few tenths of a second, d' is computed only for the first studies in each shard.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.planning.power.outcome import Sums
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.tasks.difference.probit import d_primes
from slipscale.analysis.tasks.difference.proportions import clustered_interval
from slipscale.experiments.participants.simulated_people.population import Population, curves

#: Number of studies per shard for which d' is computed.
D_PRIME_STUDIES = 10
CATCH_WIDTH, D_PRIME_LOW = "yes at catch steps", "lower bound of d'"


@dataclass(frozen=True, slots=True, kw_only=True)
class StepTask:
    """The properties of a descending difference task that affect answers.

    Parameters
    ----------
    descent_um_pp : tuple of float
        Amplitudes in a series, descending.
    series, catch_steps : int
        Number of series, and of steps without a change in each.
    trials_before, trials_after : int
        Trials of other tasks in the run before and after this one.
    """

    descent_um_pp: tuple[float, ...]
    series: int
    catch_steps: int
    trials_before: int = 0
    trials_after: int = 0

    @property
    def trials(self) -> int:
        """Number of steps, including catch steps."""
        return self.series * (len(self.descent_um_pp) - 1 + self.catch_steps)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepAnswers:
    """Answers to the steps of simulated studies, arrays of shape (studies, participants, trials).

    Parameters
    ----------
    removed_um_pp : array
        Amplitude removed by each step; 0 at catch steps.
    felt : array
        1 for "yes", 0 for "no", NaN after the person dropped out.
    """

    removed_um_pp: Array
    felt: Array


def simulate_steps(
    task: StepTask,
    *,
    participants: int,
    studies: int,
    population: Population,
    rng: np.random.Generator,
) -> StepAnswers:
    """Simulate studies step by step; for parameters, see `simulate_ratings`."""
    shape = (studies, participants)
    mean = np.array([curves(population).mean(each) for each in task.descent_um_pp])
    catch = np.concatenate(
        [_catch_marks(task, shape, rng) for _ in range(task.series)], axis=2, dtype=np.bool_
    )
    # The real steps are the same in each series, in the same order.
    place = (np.cumsum(~catch, axis=2) - 1) % (len(task.descent_um_pp) - 1)
    changes = np.where(catch, 0.0, np.abs(np.diff(mean))[place])
    removed = np.where(catch, 0.0, np.abs(np.diff(task.descent_um_pp))[place])
    threshold = population.noise * np.exp(population.threshold_sigma * rng.normal(size=shape))
    criterion = population.criterion + population.criterion_sd * rng.normal(size=shape)
    strength = changes / threshold[..., None] + rng.normal(size=changes.shape)
    felt = (strength > criterion[..., None]).astype(np.float64)
    habits = population.habits
    if habits.lapses:
        lapse = rng.uniform(size=felt.shape) < habits.lapses
        felt = np.where(lapse, rng.integers(2, size=felt.shape), felt)
    if habits.dropout:
        planned = task.trials_before + task.trials + task.trials_after
        last = np.floor(rng.uniform(size=shape) * planned)
        last = np.where(rng.uniform(size=shape) < habits.dropout, last, math.inf)
        number = task.trials_before + np.arange(task.trials)
        felt = np.where(number > last[..., None], np.nan, felt)
    return StepAnswers(removed_um_pp=removed, felt=felt)


def _catch_marks(
    task: StepTask, shape: tuple[int, int], rng: np.random.Generator
) -> NDArray[np.bool_]:
    """Draw the positions of catch steps in each series; all positions are equally likely."""
    marks = np.array([False] * (len(task.descent_um_pp) - 1) + [True] * task.catch_steps)
    return rng.permuted(np.broadcast_to(marks, (*shape, len(marks))), axis=2)


def precision(answers: StepAnswers, confidence: float) -> dict[str, Sums]:
    """Return the precision of the false-alarm rate, and the lower bounds of d'.

    Returns
    -------
    dict
        Half-widths of the interval for the proportion of "yes" at catch steps, and lower bounds of
        d' for all step sizes combined.
    """
    widths = [
        _half_width(*_catch_counts(removed, felt), confidence)
        for removed, felt in zip(answers.removed_um_pp, answers.felt, strict=True)
    ]
    bounds = [
        _lower_bound(removed, felt, confidence)
        for removed, felt in zip(
            answers.removed_um_pp[:D_PRIME_STUDIES], answers.felt[:D_PRIME_STUDIES], strict=True
        )
    ]
    return {CATCH_WIDTH: Sums.of(np.array(widths)), D_PRIME_LOW: Sums.of(np.array(bounds))}


def _catch_counts(removed: Array, felt: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the numbers of "yes" and of all answers at catch steps per participant, sorted."""
    answered = (removed == 0) & ~np.isnan(felt)
    number = answered.sum(axis=1)
    yes = np.where(answered, felt, 0.0).sum(axis=1)
    people = sorted((float(y), float(n)) for y, n in zip(yes, number, strict=True) if n)
    return tuple(y for y, _ in people), tuple(n for _, n in people)


@lru_cache(maxsize=10_000)
def _half_width(yes: tuple[float, ...], answers: tuple[float, ...], confidence: float) -> float:
    """Return the half-width of the interval for the proportion of "yes", as in the report."""
    if not answers:
        return math.nan
    found = clustered_interval(np.array(yes), np.array(answers), confidence)
    return (found.high - found.low) / 2


def _lower_bound(removed: Array, felt: Array, confidence: float) -> float:
    who, step = np.nonzero(~np.isnan(felt))
    people = np.unique(who, return_inverse=True)[1]
    changed = (removed[who, step] > 0).astype(np.float64)
    found = d_primes(changed, felt[who, step], people, confidence)
    return found[0].interval.low if found else math.nan
