"""Compare how precisely different protocols estimate a quantity in the same time.

Precision is the half-width of the group's confidence interval in % of the estimate. The estimate is
the mean of participants' exponents, or the geometric mean of their thresholds, computed as in
`analyse`. For comparisons with a standard, the threshold is half the distance between the 25 % and
75 % points. Magnitude estimation is simulated by `slipscale.analysis.planning.simulated.estimates`;
in all other protocols, simulated people answer step by step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from slipscale.analysis.planning.power.design import design_of
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.shard import excluded
from slipscale.analysis.planning.protocols.answers import Answered, StudyAnswers, answers_of
from slipscale.analysis.planning.protocols.studies import EXPONENT, ProtocolStudy, seed_of
from slipscale.analysis.planning.simulated.estimates import simulate_ratings
from slipscale.analysis.planning.simulated.fast_tests import exponents, half_widths, tables
from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.psychometrics.thresholds import threshold_values
from slipscale.analysis.tasks.thresholds.statistics import COMPARED, curve_of
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.experiments.study.file import parse_study

QUANTILES = (5, 95)
CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolPrecision:
    """Precision of the exponent or threshold from a study with a given number of participants.

    Parameters
    ----------
    study : ProtocolStudy
    participants : int
    trials : int
        Number of trials per participant in a run, including practice and other tasks.
    minutes : float
        Duration in minutes, median across participants.
    value : float
        Mean exponent, or geometric mean of the thresholds in µm peak to peak.
    half_width_percent, error : float
        Mean half-width of the 95 % interval in % of `value`, and its Monte Carlo standard error.
    low, high : float
        5th and 95th percentiles of the half-widths.
    without : float
        Proportion of studies in which fewer than three participants have a value, so that no
        interval can be computed.
    studies : int
        Number of simulated studies.
    """

    study: ProtocolStudy
    participants: int
    trials: int
    minutes: float
    value: float
    half_width_percent: float
    error: float
    low: float
    high: float
    without: float
    studies: int


def protocol_precision(
    study: ProtocolStudy,
    sizes: Sequence[int],
    *,
    studies: int,
    seed: int,
    population: Population,
    jobs: int = 1,
) -> list[ProtocolPrecision]:
    """Estimate the precision of a study for several numbers of participants.

    Parameters
    ----------
    studies : int
        Number of simulated studies. Smaller sample sizes use the first participants of the largest
        sample.
    """
    largest = max(sizes)
    if study.marks is None:
        values = _exponents(study, largest, studies, seed, population)
        minutes = study.minutes(population)
    else:
        from joblib import Parallel, delayed

        answered: list[StudyAnswers] = Parallel(n_jobs=jobs)(
            delayed(answers_of)(study, largest, seed_of(seed, study.own_name, number), population)
            for number in range(studies)
        )
        everybody = [person for one in answered for person in one.people]
        own = np.array([person.exponent if person else np.nan for person in everybody])
        found = own if study.quantity == EXPONENT else thresholds_of(everybody, study.choices)
        values = found.reshape(studies, largest)
        minutes = float(np.median([taken for one in answered for taken in one.minutes]))
    trials = study.plans(1, 0, population)[0].planned_trials()
    return [
        _summary(study, values[:, :size], trials=trials, minutes=minutes) for size in sorted(sizes)
    ]


def _summary(
    study: ProtocolStudy, values: Array, *, trials: int, minutes: float
) -> ProtocolPrecision:
    """Compute the study's precision from values of shape (studies, participants)."""
    if study.quantity == EXPONENT:
        value = _mean(values)
        percent = 100 * half_widths(values, CONFIDENCE) / value
    else:
        logs = np.log(values)
        value = math.exp(_mean(logs))
        # The interval extends from value / factor to value * factor.
        percent = 100 * np.sinh(half_widths(logs, CONFIDENCE))
    finite = percent[np.isfinite(percent)]
    low, high = np.percentile(finite, QUANTILES) if len(finite) else (np.nan, np.nan)
    return ProtocolPrecision(
        study=study,
        participants=values.shape[1],
        trials=trials,
        minutes=minutes,
        value=value,
        half_width_percent=float(finite.mean()) if len(finite) else np.nan,
        error=float(finite.std(ddof=1) / len(finite) ** 0.5) if len(finite) > 1 else np.nan,
        low=float(low),
        high=float(high),
        without=float((np.isfinite(values).sum(axis=1) < FEWEST).mean()),
        studies=len(values),
    )


def _mean(values: Array) -> float:
    """Return the mean of the finite values; NaN if there are none."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else math.nan


def _exponents(
    study: ProtocolStudy, participants: int, studies: int, seed: int, population: Population
) -> Array:
    """Simulate magnitude estimation; return exponents of shape (studies, participants)."""
    parsed = parse_study(study.text, study.name)
    design = design_of(parsed, study.text, population, 0.05)
    habits = population.habits
    condition = Condition(
        participants=participants,
        repetitions=study.number,
        lapses=habits.lapses,
        dropout=habits.dropout,
    )
    ratings = simulate_ratings(
        design.task_of(condition),
        participants=participants,
        studies=studies,
        population=population,
        rng=np.random.default_rng(seed_of(seed, study.own_name)),
    )
    if design.choices.exclusions:
        ratings = excluded(design, ratings)
    found = tables(ratings, design.task.levels, design.rule, design.choices.zero_rule)
    return np.where(found.usable[:, None], exponents(found), np.nan)


def thresholds_of(
    people: Sequence[Answered | None], choices: AnalysisChoices, *, points: bool = False
) -> Array:
    """Return participants' thresholds in µm peak to peak, or NaN.

    The study's analysis choices determine curve, axis and share. If ``points`` is True, return
    points of subjective equality for comparisons with a standard.
    """
    found = np.full(len(people), np.nan)
    for method in sorted({each.method for each in people if each}):
        own = {
            place: each.answers
            for place, each in enumerate(people)
            if each and each.answers and each.method == method
        }
        found[list(own)] = threshold_values(
            list(own.values()),
            method=method,
            curve=curve_of(method, choices),
            share=choices.threshold_share,
            half_width=method == COMPARED and not points,
        )
    return found
