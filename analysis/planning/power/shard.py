"""Simulate a shard: at most 250 studies of one condition, with a seed for the shard.

The seed is a hash of the user's seed, the shard's number and size, and all settings of the
simulation. It does not depend on the settings of the analysis. A shard gives the same result on
every machine and in every run.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from itertools import pairwise as neighbours

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.pipeline import normalised
from slipscale.analysis.planning.power.design import Design
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.outcome import Outcome, Sums
from slipscale.analysis.planning.power.sequential import Spending, levels, look_sizes
from slipscale.analysis.planning.power.yes_no_steps import precision, simulate_steps
from slipscale.analysis.planning.simulated.dataset import place_of, simulated_dataset
from slipscale.analysis.planning.simulated.estimates import Ratings, simulate_ratings
from slipscale.analysis.planning.simulated.fast_tests import (
    TESTS,
    Tables,
    exponents,
    factor_p,
    half_widths,
    pairs,
    pairwise,
    tables,
)
from slipscale.analysis.preprocessing import data_quality
from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.mixed_model import mixed_model
from slipscale.analysis.statistics.repeated_measures.omnibus import page_trend
from slipscale.analysis.tasks.effects.factors.statistics import mixed_changes
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError

#: Version of the simulation. A different version changes all seeds and invalidates the cache.
VERSION = 2
STUDIES_A_SHARD = 250
#: Significance level for deriving seeds, so that seeds do not depend on the study's level.
SEEDED_ALPHA = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Looks:
    """Number of analyses during and after a study, and their alpha spending function."""

    number: int = 1
    spending: Spending = "obrien-fleming"


@dataclass(frozen=True, slots=True, kw_only=True)
class Shard:
    """Simulated studies of one condition that are computed and cached together.

    Parameters
    ----------
    design : Design
    condition : Condition
    number : int
        Number of the shard, from 0.
    studies : int
    seed : int
    looks : Looks
    """

    design: Design
    condition: Condition
    number: int
    studies: int
    seed: int
    looks: Looks = Looks()

    @property
    def identity(self) -> dict[str, object]:
        """All settings that affect the result, as JSON data."""
        return {
            "version": VERSION,
            "design": self.design.identity,
            "condition": asdict(self.condition),
            "looks": asdict(self.looks),
            "number": self.number,
            "studies": self.studies,
            "seed": self.seed,
        }

    @property
    def digest(self) -> str:
        """SHA-256 of the shard's identity, in hexadecimal."""
        return hashlib.sha256(json.dumps(self.identity, sort_keys=True).encode()).hexdigest()

    @property
    def random_seed(self) -> int:
        """Random seed for simulated people and their answers, whatever the analysis."""
        design = replace(self.design, choices=AnalysisChoices(), alpha=SEEDED_ALPHA)
        return int(replace(self, design=design, looks=Looks()).digest, 16)

    def compute(self) -> Outcome:
        """Simulate the studies, and count significant results."""
        design, condition = self.design, self.condition
        task = design.task_of(condition)
        people = condition.people(design.population)
        rng = np.random.default_rng(self.random_seed)
        ratings = simulate_ratings(
            task,
            participants=condition.participants,
            studies=self.studies,
            population=people,
            rng=rng,
        )
        if design.choices.exclusions:
            ratings = excluded(design, ratings)
        found = tables(ratings, task.levels, design.rule, design.choices.zero_rule)
        outcome = at_once(design, found, self.looks)
        more = {**of_factors(design, ratings), **one_by_one(design, ratings)}
        outcome = replace(outcome, found={**outcome.found, **more})
        steps = design.steps_of(condition)
        # Without an effect, every step is a catch step.
        if steps is None or not condition.effect:
            return outcome
        answers = simulate_steps(
            steps,
            participants=condition.participants,
            studies=self.studies,
            population=people,
            rng=rng,
        )
        return replace(outcome, steps=precision(answers, design.choices.confidence))


def at_once(design: Design, found: Tables, looks: Looks = Looks()) -> Outcome:
    """Return the results of all vectorised tests."""
    alpha = design.alpha
    significant = {
        name: (TESTS[name](found) < alpha) & found.usable for name in design.tests if name in TESTS
    }
    if design.pairs:
        significant |= _pairs_told(design, found, alpha)
    if looks.number > 1:
        significant |= _looks_told(design, found, looks)
    confidence = design.choices.confidence
    of_means = half_widths(found.cells, confidence)
    widths = {"exponent": half_widths(exponents(found), confidence)} | {
        f"mean at {amplitude:g}": of_means[:, place] for place, amplitude in enumerate(found.levels)
    }
    return Outcome(
        studies=len(found.usable),
        unusable=int((~found.usable).sum()),
        found={name: int(share.sum()) for name, share in significant.items()},
        widths={name: Sums.of(values[found.usable]) for name, values in widths.items()},
    )


def of_factors(design: Design, ratings: Ratings) -> dict[str, int]:
    """Count the studies that detect each factor's effect, and those that detect its interaction."""
    task = design.task
    if not task.factors:
        return {}
    amplitudes = task.levels
    crossed = tables(
        replace(ratings, amplitude=ratings.condition * len(amplitudes) + ratings.amplitude),
        amplitudes * len(task.conditions),
        design.rule,
        design.choices.zero_rule,
    )
    p = factor_p(crossed.logs, [len(levels) for _, levels in task.factors])
    return {
        name: int(((values < design.alpha) & crossed.usable).sum())
        for name, values in zip(design.factor_tests, p, strict=True)
    }


def _pairs_told(design: Design, found: Tables, alpha: float) -> dict[str, NDArray[np.bool_]]:
    """Return, per pair of neighbouring amplitudes, which studies find a significant difference."""
    p = pairwise(found, design.choices.primary)
    known = pairs(found.levels)
    return {
        pair_name(*pair): (p[:, known.index(pair)] < alpha) & found.usable
        for pair in neighbours(found.levels)
    }


def _looks_told(design: Design, found: Tables, looks: Looks) -> dict[str, NDArray[np.bool_]]:
    """Return, for each interim analysis, a mask of the studies that stop at this analysis.

    A study stops when the omnibus test of its primary analysis is significant or, if the design
    does not include this test, when any pairwise test is significant.
    """
    sizes = look_sizes(found.cells.shape[1], looks.number)
    going_on = found.usable.copy()
    stopped: dict[str, NDArray[np.bool_]] = {}
    for size, level in zip(sizes, levels(sizes, design.alpha, looks.spending), strict=True):
        ends = going_on & (_any_difference(design, found.first(size)) < level)
        stopped[f"look after {size}"] = ends
        going_on &= ~ends
    return stopped


def _any_difference(design: Design, found: Tables) -> Array:
    if design.omnibus in design.tests:
        return TESTS[design.omnibus](found)
    return np.asarray(pairwise(found, design.choices.primary).min(axis=1))


def pair_name(low: float, high: float) -> str:
    """Return the name of a pair of amplitudes.

    >>> pair_name(0.0, 0.5)
    '0 - 0.5'
    """
    return f"{low:g} - {high:g}"


def excluded(design: Design, ratings: Ratings) -> Ratings:
    """Return the ratings without the participants excluded by the study's rule.

    The quality measures are computed as in `analyse`, one study at a time.
    """
    choices = design.choices
    percent = ratings.percent.copy()
    for study in range(len(percent)):
        data = _dataset(design, ratings, study)
        measured = data_quality.measures(data, choices.thresholds)
        flags = data_quality.flags(measured, choices.thresholds)
        out = flags[list(choices.exclusions)].any(axis=1)
        percent[study, [place_of(str(who)) for who in out.index[out]]] = np.nan
    return replace(ratings, percent=percent)


def _dataset(design: Design, ratings: Ratings, study: int) -> Dataset:
    return simulated_dataset(
        ratings,
        study,
        design.task.levels,
        design.choices,
        declared=design.declared,
        conditions=design.task.conditions,
    )


def one_by_one(design: Design, ratings: Ratings) -> dict[str, int]:
    """Count the significant results of tests that analyse one study at a time."""
    slow = [name for name in design.tests if name in SLOW]
    contrasts = design.mixed_tests
    factors = {factor for factor, _, _ in contrasts.values()}
    found = dict.fromkeys([*slow, *contrasts], 0)
    for study in range(len(ratings.percent) if found else 0):
        data = _dataset(design, ratings, study)
        try:
            _, prepared, _, _ = normalised(data, None)
        except UserError:
            continue  # `analyse` would reject these data.
        for name in slow:
            found[name] += bool(prepared and SLOW[name](prepared) < design.alpha)
        if prepared is None or prepared.refused:
            continue
        changes = {factor: mixed_changes(prepared, factor) for factor in factors}
        for name, (factor, level, what) in contrasts.items():
            change = changes[factor].get((level, what))
            found[name] += bool(change and change.p < design.alpha)
    return found


def _page_p(data: Prepared) -> float:
    found = page_trend(data)
    return found.p if found else 1.0


def _mixed_model_p(data: Prepared) -> float:
    from scipy import stats

    found = mixed_model(data)
    if not found:
        return 1.0
    return float(2 * stats.t.sf(abs(found.exponent) / found.se, found.n - 1))


#: Functions that return the p-value of a test for one study, keyed by the test's name.
SLOW: dict[str, Callable[[Prepared], float]] = {
    "page_trend": _page_p,
    "mixed_model": _mixed_model_p,
}
