"""Simulate magnitude estimation in thousands of studies at once, with array operations.

The model is the same as in `slipscale.experiments.participants.simulated_people.respondent`; a test
compares the two implementations. Pilots need simulated people who answer one trial at a time and
can be resumed, whereas a power analysis needs millions of answers. Random numbers are drawn with
NumPy.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.planning.simulated.orders import draw_orders
from slipscale.analysis.statistics.arrays import Array
from slipscale.experiments.participants.simulated_people.habits import (
    ROUND_TO_PERCENT,
    Frame,
    History,
    distorts,
    reported,
)
from slipscale.experiments.participants.simulated_people.population import Population, curves

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.experiments.protocol_parts.ordering.orders import Rule

    #: Names of factors, each with its levels.
    Factors = tuple[tuple[str, tuple[str, ...]], ...]

#: Number of population quantiles at which sensation is tabulated for interpolation.
PLACES = 241
FARTHEST = 6.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Properties of a magnitude-estimation task that affect the answers.

    Parameters
    ----------
    levels : tuple of float
        Amplitudes in ascending order.
    repetitions, practice : int
        Number of ratings per surface in main trials, and in practice before them.
    order : {"blocked", "simple", "williams"}
        Rule for the order of surfaces. Unless the order is "simple", a rest follows each
        repetition.
    no_immediate_repeat : bool
        Whether immediate repetitions of a surface are excluded.
    trials_before : int
        Number of trials in tasks before this one.
    trials_after : int
        Number of trials in tasks after this one, during which participants may drop out.
    factors : tuple of (str, tuple of str)
        Names and levels of factors; the task is repeated in each combination of levels.
    """

    levels: tuple[float, ...]
    repetitions: int = 1
    practice: int = 0
    order: Rule = "blocked"
    no_immediate_repeat: bool = True
    trials_before: int = 0
    trials_after: int = 0
    factors: Factors = ()

    @property
    def conditions(self) -> list[dict[str, str]]:
        """All combinations of factor levels; without factors, a single empty combination."""
        names = [name for name, _ in self.factors]
        levels = product(*(levels for _, levels in self.factors))
        return [dict(zip(names, each, strict=True)) for each in levels]

    @property
    def trials(self) -> int:
        """Number of trials in a condition, including practice."""
        return len(self.levels) * (self.repetitions + self.practice)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratings:
    """Estimates in the main trials of simulated studies.

    Parameters
    ----------
    amplitude : int array, shape (studies, participants, trials)
        Index of each trial's amplitude in the ascending list of amplitudes. Trials are in order of
        presentation. Each participant has the same number of trials at each amplitude.
    percent : array, shape as ``amplitude``
        Estimates in % of the participant's scale; NaN after the participant dropped out.
    scale_top : array, shape (studies, participants)
    condition : int array, shape as ``amplitude``
        Index of each trial's condition; 0 if the study has no factors.
    """

    amplitude: NDArray[np.int64]
    percent: Array
    scale_top: Array
    condition: NDArray[np.int64] | int = 0

    def means(self, amplitudes: int) -> Array:
        """Return mean estimates in % of the scale, shape (studies, participants, amplitudes)."""
        return means(self.by_amplitude(self.percent, amplitudes))

    def by_amplitude(self, values: Array, amplitudes: int) -> Array:
        """Group trial values by amplitude.

        Returns
        -------
        array, shape (repetitions, studies, participants, amplitudes)
        """
        order = np.argsort(self.amplitude, axis=2, kind="stable")
        sorted_ = np.take_along_axis(values, order, axis=2)
        repeated = sorted_.reshape(*self.scale_top.shape, amplitudes, -1)
        return np.ascontiguousarray(np.moveaxis(repeated, 3, 0))


def means(values: Array) -> Array:
    """Return means over the first axis, ignoring NaN; NaN if all values are NaN."""
    if len(values) == 1:
        return np.asarray(values[0])
    present = ~np.isnan(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(present, values, 0.0).sum(axis=0) / present.sum(axis=0))


def simulate_ratings(
    task: Task, *, participants: int, studies: int, population: Population, rng: np.random.Generator
) -> Ratings:
    """Simulate studies, trial by trial.

    Parameters
    ----------
    task : Task
    participants, studies : int
    population : Population
    rng : Generator
        The only source of random numbers.
    """
    shape = (studies, participants)
    people = _People(task, shape, population, rng)
    conditions = len(task.conditions)
    turns = np.zeros((*shape, 1), np.int64)
    if conditions > 1:
        turns = draw_orders(
            "williams", conditions, 1, 0, no_immediate_repeat=False, shape=shape, rng=rng
        )
    order = np.concatenate(
        [
            draw_orders(
                task.order,
                len(task.levels),
                task.repetitions,
                task.practice,
                no_immediate_repeat=task.no_immediate_repeat,
                shape=shape,
                rng=rng,
            )
            for _ in range(conditions)
        ],
        axis=2,
    )
    condition = np.repeat(turns, task.trials, axis=2)
    trials = range(order.shape[2])
    percent = np.stack(
        [people.rate(order[..., trial], condition[..., trial]) for trial in trials], axis=2
    )
    habits = population.habits
    if habits.dropout:
        planned = task.trials_before + len(trials) + task.trials_after
        last = np.floor(rng.uniform(size=shape) * planned)
        last = np.where(rng.uniform(size=shape) < habits.dropout, last, np.inf)
        number = task.trials_before + np.arange(len(trials))
        percent = np.where(number > last[..., None], np.nan, percent)
    main = np.arange(len(trials)) % task.trials >= people.practice
    tops = rng.choice(np.array(population.scale_tops), size=shape)
    return Ratings(
        amplitude=order[..., main],
        percent=percent[..., main],
        scale_top=tops,
        condition=condition[..., main],
    )


class _People:
    """All participants in several simulated studies, with their trial history."""

    def __init__(
        self, task: Task, shape: tuple[int, int], population: Population, rng: np.random.Generator
    ) -> None:
        self.population, self.habits, self.rng, self.shape = (
            population,
            population.habits,
            rng,
            shape,
        )
        known = curves(population)
        amplitudes = task.levels
        self.block = len(amplitudes) if task.order != "simple" else 0
        self.practice, self.planned = task.practice * len(amplitudes), task.trials
        self.conditions = task.conditions
        self.changing = population.effects or population.growths or population.effect_sds
        self.deviates: dict[str, Array] = {}
        self.amplitudes = np.array(amplitudes)
        self.tables = _tables(population, amplitudes)
        self.turns = np.array([known.turns(amplitude) for amplitude in amplitudes])
        self.logs = np.log([known.mean(amplitude) for amplitude in amplitudes])
        self.intercept, self.exponent = rng.normal(size=shape), rng.normal(size=shape)
        sigma = population.noise_sigma
        self.noise = math.sqrt(population.trial_to_trial) * np.exp(
            sigma * rng.normal(size=shape) - sigma**2
        )
        self.misread = rng.uniform(size=shape) < self.habits.misread
        self.pace = np.exp(population.pace_sigma * rng.normal(size=shape))
        ends = population.levels[0], population.levels[-1]
        low, high = (math.log(known.mean(end)) for end in ends)
        self.frame = Frame(log_range=abs(high - low), middle_level=sum(ends) / 2)
        self.distorts = distorts(self.habits)
        self.past = History(contact_s=np.zeros(shape))
        self.before = np.zeros(shape)

    def rate(self, which: NDArray[np.int64], condition: NDArray[np.int64]) -> Array:
        """Simulate one estimate per participant, in % of the participant's scale.

        ``which`` and ``condition`` contain the indices of each participant's amplitude and
        condition.
        """
        self._feel(which)
        noise = self.noise * self.rng.normal(size=self.shape)
        if self.habits.learning:
            noise = noise * float(self.past.trials) ** -self.habits.learning
        turns = self.turns[which]
        deviate = turns[..., 0] * self.intercept + turns[..., 1] * self.exponent + noise
        place = (np.clip(deviate, -FARTHEST, FARTHEST) + FARTHEST) * ((PLACES - 1) / (2 * FARTHEST))
        below = np.minimum(place.astype(np.int64), PLACES - 2)
        lower, upper = self.tables[which, below], self.tables[which, below + 1]
        percent = np.asarray(lower + (place - below) * (upper - lower))
        if self.habits.misread:
            percent = np.where(self.misread, 100 - percent, percent)
        for number, levels in enumerate(self.conditions if self.changing else ()):
            changed = self.population.in_condition(percent, levels, self._own)
            percent = np.where(condition == number, changed, percent)
        if self.distorts:
            percent = np.asarray(reported(percent, self.habits, self.past, self.frame))
        if self.habits.lapses:
            percent = self._instead(percent, self.habits.lapses, self._anything())
        # People answer in whole per cent of their scale, so ties and zeros occur.
        percent = np.asarray(np.round(np.minimum(percent, 100)), np.float64)
        if self.habits.rounding:
            rounded = np.asarray(np.round(percent / ROUND_TO_PERCENT) * ROUND_TO_PERCENT)
            percent = self._instead(percent, self.habits.rounding, rounded)
        return percent

    def _feel(self, which: NDArray[np.int64]) -> None:
        """Add a trial to the history of every participant."""
        trials = self.past.trials
        amplitude = self.amplitudes[which]
        self.past = self.past.with_trial(self.logs[which], self.before if trials else amplitude)
        self.before = amplitude
        if not self.habits.settling:
            return
        rested = trials % self.planned == self.practice or (self.block and trials % self.block == 0)
        contact_s = np.zeros(self.shape) if rested else self.past.contact_s
        people = self.population
        wish_s = people.exploration_s * self.pace
        contact_s = contact_s + wish_s * np.exp(
            people.exploration_sigma * self.rng.normal(size=self.shape)
        )
        self.past = self.past.after_contact(contact_s)

    def _own(self, purpose: str) -> Array:
        """Return one standard normal deviate per participant, drawn once for each purpose."""
        if purpose not in self.deviates:
            self.deviates[purpose] = self.rng.normal(size=self.shape)
        return self.deviates[purpose]

    def _anything(self) -> Array:
        return 100 * self.rng.uniform(size=self.shape)

    def _instead(self, percent: Array, share: float, other: Array) -> Array:
        return np.where(self.rng.uniform(size=self.shape) < share, other, percent)


def _tables(population: Population, amplitudes: Sequence[float]) -> Array:
    """Tabulate population quantiles of the sensation, with one row per amplitude."""
    from scipy.special import betaincinv, ndtr

    places = ndtr(np.linspace(-FARTHEST, FARTHEST, PLACES))
    known = curves(population)
    return np.array([100 * betaincinv(*known.shapes(each), places) for each in amplitudes])
