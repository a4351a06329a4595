"""Measure the bias and coverage of each quantity that is estimated in simulated studies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from benchmarks import simulated_truths as truths
from slipscale.analysis.statistics.mean_over_participants import MeanOverParticipants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import (
    Answers,
    PsychometricFunction,
)
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold_by_posterior
from slipscale.analysis.tasks.matching.statistics import matching
from slipscale.analysis.tasks.scales.difference_scaling import (
    difference_scale,
    triads_as_quadruples,
)
from slipscale.analysis.tasks.scales.paired_comparison_scale import bradley_terry, thurstone
from slipscale.analysis.tasks.scales.statistics import scales
from slipscale.analysis.tasks.thresholds.population_threshold import (
    population_threshold,
    weber_fraction,
)
from slipscale.analysis.tasks.thresholds.statistics import COMPARED, CURVE_OF
from slipscale.experiments.study.analysis_choices import AnalysisChoices

if TYPE_CHECKING:
    from slipscale.analysis.reading.dataset import Dataset
    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.experiments.participants.simulated_people.population import Population

SEED = 15
#: Number of participants per study for intervals of populations.
PEOPLE = 8
STANDARD_UM_PP = 1.2


def label(number: int) -> str:
    """Return the label of a participant, counted from 1."""
    return f"{number:05d}"


@dataclass(frozen=True)
class Row:
    """Bias and coverage of one quantity in one case.

    Parameters
    ----------
    what, unit : str
        The quantity, and the unit of `bias`.
    runs : int
        Number of estimates. A scale has one estimate per surface and study.
    without : int
        Runs without an estimate.
    bias, error : float
        Mean of estimate minus true value, and its standard error.
    coverage : float or None
        Proportion of 95 % intervals that contain the true value.
    """

    what: str
    unit: str
    runs: int
    without: int
    bias: float
    error: float
    coverage: float | None


@dataclass(frozen=True)
class Case:
    """A study to simulate, and what is measured."""

    title: str
    study: str
    people: Population
    each: int  # Number of participants per study.
    measure: Callable[[Dataset, Case, int], list[Row]]
    intervals: int = 2
    standard_level: float = STANDARD_UM_PP


def row(what: str, unit: str, found: Iterable[tuple[float, bool | None] | None]) -> Row:
    """Summarise pairs: an error, and whether the interval contains the true value."""
    everything = list(found)
    there = [one for one in everything if one is not None]
    errors = np.array([error for error, _ in there if np.isfinite(error)])
    held = [holds for _, holds in there if holds is not None]
    return Row(
        what=what,
        unit=unit,
        runs=len(there),
        without=len(everything) - len(there),
        bias=float(errors.mean()),
        error=float(errors.std(ddof=1) / len(errors) ** 0.5),
        coverage=float(np.mean(held)) if held else None,
    )


def compared(
    value: float, interval: ConfidenceInterval, truth: float, *, log: bool
) -> tuple[float, bool]:
    """Return the error (in decades if ``log``), and whether the interval contains the truth."""
    error = float(np.log10(value / truth)) if log else value - truth
    return error, bool(interval.low <= truth <= interval.high)


def measure_thresholds(data: Dataset, case: Case, runs: int) -> list[Row]:
    """Measure thresholds of individuals (one run each) and of groups of `PEOPLE` people."""
    method = str(data.trials["forced_choices"]["method"].iloc[0])
    two_sided = method == COMPARED
    ours: list[PsychometricFunction | NotComputed] = []
    true = []
    main = data.trials["forced_choices"][~data.trials["forced_choices"]["catch"]]
    rows_of = dict(list(main.groupby("participant_id", observed=True)))
    for number in range(1, runs + 1):
        noise = truths.own_noise(case.people, SEED, label(number))
        rows = rows_of[f"sub-{label(number)}"]
        answers = Answers.of_trials(rows["track_level"].tolist(), rows["correct"].tolist())
        curve = CURVE_OF.get(method, "weibull")
        ours.append(fit_threshold_by_posterior(answers, method=method, curve=curve))
        true.append(
            truths.comparison(case.people, noise, case.standard_level)
            if two_sided
            else truths.forced_choice(case.people, noise, case.standard_level, case.intervals)
        )
    places = [case.standard_level if two_sided else each.track_level for each in true]
    name, unit = ("equality", "µm") if two_sided else ("threshold", "decades")
    shown = [
        row(
            name,
            unit,
            (_threshold(one, at, log=not two_sided) for one, at in zip(ours, places, strict=True)),
        )
    ]
    shown.append(
        row("slope", "decades", (_slope(one, t.slope) for one, t in zip(ours, true, strict=True)))
    )
    if two_sided:
        found = zip(ours, true, strict=True)
        shown.append(row("Weber fraction", "decades", (_weber(one, t, case) for one, t in found)))
    typical = _typical(case, two_sided=two_sided)
    populations = (
        _population(
            pd.concat([rows_of[f"sub-{label(n + 1)}"] for n in range(first, first + PEOPLE)]),
            typical,
            method,
        )
        for first in range(0, runs - PEOPLE + 1, PEOPLE)
    )
    shown.append(row(f"{name}, {PEOPLE} people", unit, populations))
    catches = data.trials["forced_choices"][data.trials["forced_choices"]["catch"]]
    if len(catches):
        shown.append(_catches(catches, case, two_sided=two_sided))
    return shown


def _threshold(
    one: PsychometricFunction | NotComputed, truth: float, *, log: bool
) -> tuple[float, bool | None] | None:
    if isinstance(one, NotComputed):
        return None
    return compared(one.threshold_level.value, one.threshold_level.interval, truth, log=log)


def _slope(
    one: PsychometricFunction | NotComputed, truth: float
) -> tuple[float, bool | None] | None:
    if isinstance(one, NotComputed) or isinstance(one.slope, NotComputed):
        return None
    return compared(one.slope.value, one.slope.interval, truth, log=True)


def _weber(
    one: PsychometricFunction | NotComputed, truth: truths.Threshold, case: Case
) -> tuple[float, bool | None] | None:
    found = one if isinstance(one, NotComputed) else weber_fraction(one, case.standard_level)
    if not found:
        return None
    part = truth.track_level / case.standard_level
    return compared(found.value, found.interval, part, log=True)


def _typical(case: Case, *, two_sided: bool) -> float:
    """Return the population's threshold: the geometric mean of many people's thresholds."""
    if two_sided:
        return case.standard_level
    sigma = case.people.threshold_sigma
    logs = [
        np.log(
            truths.forced_choice(
                case.people,
                case.people.noise * float(np.exp(sigma * z)),
                case.standard_level,
                case.intervals,
            ).track_level
        )
        for z in np.linspace(-2.5, 2.5, 21)
    ]
    weights = np.exp(-(np.linspace(-2.5, 2.5, 21) ** 2) / 2)
    return float(np.exp(np.average(logs, weights=weights)))


def _population(rows: pd.DataFrame, truth: float, method: str) -> tuple[float, bool | None] | None:
    curve = CURVE_OF.get(method, "weibull")
    found = population_threshold(rows, AnalysisChoices(), method=method, curve=curve)
    if not found:
        return None
    estimate = found.threshold_level
    return compared(estimate.value, estimate.interval, truth, log=method != COMPARED)


def _catches(catches: pd.DataFrame, case: Case, *, two_sided: bool) -> Row:
    """Return a row for catch trials: their answers, minus the expected proportion."""
    yes_no = two_sided and bool((catches["track_level"] == catches["standard_level"]).all())
    lapses = case.people.habits.lapses
    right = catches["correct"].to_numpy(bool)
    if two_sided and not yes_no:
        right = right == (catches["track_level"] > catches["standard_level"]).to_numpy()
    expected = 0.5 if yes_no else 1 - lapses + lapses / case.intervals
    said = "“yes” to the standard itself" if yes_no else "catch trials right"
    return row(
        f"{said} (expected {expected:.3f})", "share", ((each - expected, None) for each in right)
    )


def measure_scales(data: Dataset, case: Case, runs: int) -> list[Row]:
    """Measure scales in studies of `case.each` people.

    The true values are scales that are fitted to the population's expected proportions.
    """
    surfaces = [float(each) for each in _amplitudes(case.study)]
    triads = bool((data.trials["comparisons"]["stimulus3"] != "").any())
    if triads:
        expected = _expected_differences(case.people, surfaces)
        models = {"differences": (expected[:-1], slice(1, -1))}
    else:
        share = truths.chosen_over(case.people, surfaces)
        counts = np.round(1e7 * share) * (1 - np.eye(len(surfaces)))
        models = {}
        for name, fit in (("bradley_terry", bradley_terry), ("thurstone", thurstone)):
            known = fit(counts)
            if isinstance(known, NotComputed):
                raise SystemExit(known.reason)
            models[name] = (np.array(known.values), slice(None))
    found: dict[str, list[tuple[float, bool | None] | None]] = {name: [] for name in models}
    noises: list[tuple[float, bool | None] | None] = []
    for own in _studies(data.trials["comparisons"], case.each, runs):
        tasks = scales(own)
        if isinstance(tasks, NotComputed):
            raise SystemExit(tasks.reason)
        for name, (values, which) in models.items():
            scale = getattr(tasks[0], name)
            if not scale:
                found[name].append(None)
                noises += [None] * triads
                continue
            every = [
                compared(value, interval, truth, log=False)
                for value, interval, truth in zip(
                    scale.values[which],  # noqa: PD011 - a tuple
                    scale.intervals[which],
                    values[which],
                    strict=True,
                )
            ]
            # The values of a scale sum to 0, so only the last value contributes to the bias; all
            # values contribute to the coverage.
            found[name] += [(np.nan, holds) for _, holds in every[:-1]]
            found[name].append(every[-1])
            if triads:
                noises.append(
                    compared(scale.noise, scale.noise_interval, float(expected[-1]), log=True)
                )
    titles = {
        "bradley_terry": ("Bradley-Terry, values", "log odds"),
        "thurstone": ("Thurstone V, values", "SD"),
        "differences": ("values between the ends", "of the scale"),
    }
    shown = [row(*titles[name], each) for name, each in found.items()]
    return [*shown, row("noise", "decades", noises)] if triads else shown


def _expected_differences(people: Population, surfaces: list[float]) -> np.ndarray:
    """Fit a difference scale to the expected proportions; return its values, then the noise."""
    share = truths.second_step_larger(people, surfaces)
    each = 20_000
    ranks = np.repeat(np.array(list(share)), each, axis=0)
    larger = np.concatenate([np.arange(each) < round(each * p) for p in share.values()])
    known = difference_scale(triads_as_quadruples(ranks), larger, simulations=20)
    if isinstance(known, NotComputed):
        raise SystemExit(known.reason)
    return np.array([*known.values, known.noise])  # noqa: PD011 - a tuple


def measure_matching(data: Dataset, case: Case, runs: int) -> list[Row]:
    """Measure constant errors and the effect of direction, in studies of `case.each` people."""
    (reference,) = _amplitudes(case.study)
    ends = {
        sign: truths.matched(case.people, float(reference), sign=sign, nearest=0.3, furthest=0.6)
        for sign in (1, -1)
    }
    true = {
        "bias_level": (ends[1] + ends[-1]) / 2 - float(reference),
        "direction_level": ends[-1] - ends[1],
    }
    found: dict[str, list[tuple[float, bool | None] | None]] = {name: [] for name in true}
    for own in _studies(data.trials["matches"], case.each, runs):
        tasks = matching(own)
        if isinstance(tasks, NotComputed):
            raise SystemExit(tasks.reason)
        for name, truth in true.items():
            mean = getattr(tasks[0], name)
            found[name].append(
                compared(mean.mean, mean.interval, truth, log=False)
                if isinstance(mean, MeanOverParticipants)
                else None
            )
    titles = {"bias_level": "constant error", "direction_level": "from above minus from below"}
    return [row(titles[name], "µm", each) for name, each in found.items()]


def _studies(rows: pd.DataFrame, each: int, runs: int) -> Iterator[pd.DataFrame]:
    """Yield the rows of each study: `each` consecutive participants."""
    number = rows["participant_id"].astype(str).str.removeprefix("sub-").astype(int)
    for study in range(runs):
        own = rows[(number - 1) // each == study]
        yield own.assign(participant_id=own["participant_id"].cat.remove_unused_categories())


def _amplitudes(study: str) -> list[str]:
    return study.split("amplitudes_um_pp = [")[1].split("]", maxsplit=1)[0].split(", ")
