"""Measure interval coverage and error rates (docs/validation/measured/statistics.md).

Simulated studies of n = 3, 6, 12 and 30 participants, with known true values, are analysed with
the analysis's own functions. Run: .venv/bin/python -m benchmarks.coverage [--studies 200] [--write]
"""

from __future__ import annotations

import argparse
import gc
import time
import warnings
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from benchmarks.measured_page import put
from slipscale.analysis.preprocessing.log_transform import Prepared, prepare
from slipscale.analysis.statistics.descriptives import student_intervals, within_intervals
from slipscale.analysis.statistics.effect_sizes import hedges_g
from slipscale.analysis.statistics.equivalence import equivalence
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.mixed_model import MixedModel, mixed_model
from slipscale.analysis.statistics.power_law import PowerLaw, power_law
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold
from slipscale.analysis.statistics.reliability import Reliability, reliability
from slipscale.analysis.statistics.repeated_measures import omnibus
from slipscale.analysis.statistics.repeated_measures.pairwise import PairedT, pairwise
from slipscale.analysis.tasks.difference.probit import d_primes
from slipscale.analysis.tasks.difference.proportions import clustered_interval
from slipscale.analysis.tasks.difference.step_size_curve import Measure, psychometric
from slipscale.analysis.tasks.difference.yes_no import TRIALS_FOR_OWN
from slipscale.analysis.tasks.effects.groups.statistics import GroupComparison, compare_groups
from slipscale.analysis.tasks.estimation.order_effects import OrderEffects, order_effects
from slipscale.experiments.study.analysis_choices import AnalysisChoices

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.analysis.statistics.not_computed import NotComputed

    Array = NDArray[np.float64]
    #: Simulates one study, and returns whether an interval covers the true value or a test errs
    #: (None if the result is not computed).
    Trial = Callable[[np.random.Generator, int], bool | None]

SIZES = (3, 6, 12, 30)
#: Divisors of the number of studies for slow rows; these rows report their number of studies.
SLOW = {
    "exponent, mixed model": 5,
    "exponent difference between two groups of n, Welch": 4,
    "individual threshold, 4 sizes, n answers each (one participant)": 4,
    "growth in two groups of n, mixed ANOVA": 4,
}
AMPLITUDES = np.array([0.3, 0.5, 1.2, 2.3])
EXPONENT, SD_EXPONENT, SD_PERSON, SD_TRIAL = 0.6, 0.15, 0.5, 0.3


def study(
    rng: np.random.Generator,
    n: int,
    *,
    exponent: float = EXPONENT,
    repetitions: int = 3,
    zeros: float = 0.0,
    drift: float = 0.0,
    carry: float = 0.0,
) -> Prepared:
    """Return a study with power functions and a proportion of zeros at the smallest level."""
    rows = []
    # People's exponents vary only if the mean is not 0; otherwise, nobody has an effect.
    spread = SD_EXPONENT if exponent else 0.0
    for who in range(n):
        own, slope, before = rng.normal(3, SD_PERSON), rng.normal(exponent, spread), 0.0
        for position, a in enumerate(rng.permutation(np.repeat(AMPLITUDES, repetitions))):
            log = own + slope * np.log(a) + drift * position + carry * before
            zero = a == AMPLITUDES[0] and rng.random() < zeros
            rows.append((f"p{who:02d}", a, 0.0 if zero else np.exp(rng.normal(log, SD_TRIAL))))
            before = float(a)
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "normalised"])
    frame["participant_id"] = frame["participant_id"].astype("category")
    return prepare(frame.assign(session="", run="1"), AnalysisChoices())


def holds(interval: Iterable[float] | None, truth: float) -> bool | None:
    if interval is None:
        return None
    low, high = interval
    return None if np.isnan(low) else bool(low <= truth <= high)


def mean_interval(rng: np.random.Generator, n: int, *, log: bool) -> bool | None:
    """Return whether the t-based interval covers the (geometric) mean of skewed estimates."""
    values = rng.normal(3, 0.6, (n, 1))
    low, high = student_intervals(pd.DataFrame(values if log else np.exp(values)), 0.95)
    truth = 3.0 if log else float(np.exp(3 + 0.6**2 / 2))
    return holds((low[0], high[0]), truth)


def within(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether within-participant bars, times √2, cover the true ratio of two means."""
    logs = study(rng, n).logs
    low, high = within_intervals(logs, 0.95)
    half = float(np.log(high[3] / low[3])) / 2 * 2**0.5
    centre = float(logs[2.3].mean() - logs[0.5].mean())
    truth = EXPONENT * float(np.log(2.3 / 0.5))
    return holds((centre - half, centre + half), truth)


def exponent(rng: np.random.Generator, n: int, zeros: float = 0.0) -> bool | None:
    """Return whether the t-based interval for the mean exponent contains the true value."""
    found = power_law(study(rng, n, zeros=zeros))
    return holds(found.interval, EXPONENT) if isinstance(found, PowerLaw) else None


def mixed(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether the mixed model's interval contains the true exponent."""
    found = mixed_model(study(rng, n))
    return holds(found.interval, EXPONENT) if isinstance(found, MixedModel) else None


def ratio(rng: np.random.Generator, n: int, zeros: float = 0.0) -> bool | None:
    """Return whether the interval for a ratio of geometric means contains the true ratio."""
    data = study(rng, n, zeros=zeros)
    two = [1.2, 2.3]
    found = pairwise(replace(data, cells=data.cells[two], logs=data.logs[two]))
    if not found or not isinstance(found[-1].logs, PairedT):
        return None
    return holds(found[-1].logs.ratio_interval, float((2.3 / 1.2) ** EXPONENT))


def errs(test: str) -> Trial:
    """Return a function that checks for a test's false alarm if amplitude has no effect."""

    def once(rng: np.random.Generator, n: int) -> bool | None:
        data = study(rng, n, exponent=0.0, zeros=0.0)
        if test == "anova":
            anova = omnibus.rm_anova(data)
            return anova.p_gg < 0.05 if anova else None
        if test == "friedman":
            ranks = omnibus.friedman(data)
            return ranks.p < 0.05 if ranks else None
        pairs = pairwise(data)
        if not pairs:
            return None
        ps = [
            pair.ranks.p_holm if test == "wilcoxon" else getattr(pair.logs, "p_holm", np.nan)
            for pair in pairs
        ]
        return bool(np.nanmin(ps) < 0.05)

    return once


def order_errs(which: str, **effects: float) -> Trial:
    """Return a function that checks for a false alarm of an order effect that is absent."""

    def once(rng: np.random.Generator, n: int) -> bool | None:
        found = order_effects(study(rng, n, **effects))  # type: ignore[arg-type]
        if not isinstance(found, OrderEffects):
            return None
        slope = getattr(found, which)
        return slope.p < 0.05 if isinstance(slope, MeanOverParticipants) else None

    return once


def icc(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether the interval for a single estimate's reliability contains the true value."""
    own = rng.normal(0, 0.5, (n, 1, 1)) + rng.normal(0, 0.3, (n, 4, 1))
    logs = own + rng.normal(0, 0.4, (n, 4, 3))
    who, what, _ = np.indices(logs.shape)
    frame = pd.DataFrame(
        {
            "participant_id": pd.Categorical([f"p{i:02d}" for i in who.ravel()]),
            "level": AMPLITUDES[what.ravel()],
            "normalised": np.exp(logs.ravel()),
        }
    )
    found = reliability(prepare(frame.assign(session="", run="1"), AnalysisChoices()))
    return holds(found.single.interval, 0.34 / 0.5) if isinstance(found, Reliability) else None


def d_prime(truth: float, steps: int, catches: int, spread: float = 0.0) -> Trial:
    """Return a function that checks the interval for d' if people's criteria (and d') differ."""
    from scipy.stats import norm

    def once(rng: np.random.Generator, n: int) -> bool | None:
        who = np.repeat(np.arange(n), steps + catches)
        sizes = np.tile([1.0] * steps + [0.0] * catches, n)
        criterion, own = rng.normal(0.8, 0.4, n), rng.normal(truth, spread, n)
        felt = rng.random(len(who)) < norm.cdf(own[who] * sizes - criterion[who])
        found = d_primes(sizes, felt.astype(float), who, 0.95)
        return holds(found[0].interval, truth) if found else None

    return once


def groups(rng: np.random.Generator, n: int, gap: float = 0.0) -> GroupComparison | NotComputed:
    """Compare two groups of n people whose mean exponents differ by `gap`."""
    first, second = study(rng, n), study(rng, n, exponent=EXPONENT + gap)
    trials = pd.concat(
        [
            one.trials.assign(participant_id=name + one.trials["participant_id"].astype(str))
            for name, one in (("a", first), ("b", second))
        ],
        ignore_index=True,
    )
    trials["participant_id"] = trials["participant_id"].astype("category")
    people = trials["participant_id"].cat.categories
    data = prepare(trials, AnalysisChoices())
    return compare_groups(data, pd.Series([one[0] for one in people], index=people, name="group"))


def group_gap(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether Welch's interval for a difference in exponents contains the true value."""
    found = groups(rng, n, 0.2)
    if not found or not found.exponents:
        return None
    return holds(found.exponents.pairs[0].interval, -0.2)


def group_effect_size(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether the interval for Hedges' g contains the true value if group SDs differ."""
    g = hedges_g(rng.normal(0.8, 1.2, n), rng.normal(0, 0.8, n), 0.95)[1]
    return holds(g, 0.8 / ((1.2**2 + 0.8**2) / 2) ** 0.5)


def group_errs(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether a test finds a difference between groups with equal mean exponents."""
    found = groups(rng, n)
    if not found or not found.anova:
        return None
    return found.anova.interaction.p < 0.05


def equal_errs(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether a ratio exactly at the bound is declared equivalent."""
    bound = float((2.3 / 1.2) ** EXPONENT)
    logs = study(rng, n).logs
    mean = mean_over_participants((logs[2.3] - logs[1.2]).to_numpy(float), 0.95)
    return equivalence(mean, bound).p < 0.05 if mean else None


def half_yes(measure: Measure) -> Trial:
    """Return a function that checks the interval for the step size with 50 % "yes" (0.5 µm)."""

    def once(rng: np.random.Generator, n: int) -> bool | None:
        removed = np.tile([0.0, 0.3, 0.6, 0.9] * 3, n)
        who = np.repeat(np.arange(n), 12)
        # People's criteria differ; half of the population answers "yes" to a step of 0.5 µm.
        felt = rng.random(len(who)) < 1 / (1 + np.exp(3 - 6 * removed - rng.normal(0, 0.5, n)[who]))
        steps = pd.DataFrame(
            {
                "participant_id": who,
                "level_before": 2.0,
                "level": 2.0 - removed,
                "difference_felt": felt.astype(float),
            }
        )
        found = psychometric(steps, 0.95, measure)
        if not found or found.half_yes_interval is None:
            return None
        return holds(found.half_yes_interval, 0.5 if measure == "removed_level" else 0.25)

    return once


def own_threshold(rng: np.random.Generator, n: int) -> bool | None:
    """Return whether one participant's interval contains the threshold (n answers per size)."""
    sizes = np.repeat([0.0, 0.3, 0.6, 0.9], n)
    felt = 0.05 + 0.93 / (1 + np.exp(-12 * (sizes - 0.5)))
    answers = Answers.of_trials(sizes.tolist(), (rng.random(len(sizes)) < felt).tolist())
    if len(sizes) < TRIALS_FOR_OWN:
        return None
    found = fit_threshold(answers, method="yes_no", curve="logistic")
    return holds(found.threshold_level.interval, 0.5) if found else None


def share(p: float, answers: int, alike: float) -> Trial:
    """Return a function that checks the interval for a proportion of correlated answers."""

    def once(rng: np.random.Generator, n: int) -> bool | None:
        weight = (1 - alike) / alike if alike else 1e9
        own = rng.beta(p * weight, (1 - p) * weight, n)
        yes = rng.binomial(answers, own).astype(float)
        return holds(clustered_interval(yes, np.full(n, float(answers))), p)

    return once


COVERAGE: dict[str, Trial] = {
    "mean, t interval (log-normal estimates, SD 0.6)": lambda r, n: mean_interval(r, n, log=False),
    "geometric mean, t interval on logarithms": lambda r, n: mean_interval(r, n, log=True),
    "within-participant bars (difference between two)": within,
    "exponent, mean of slopes": exponent,
    "exponent, 20 % zeros at the smallest amplitude": lambda r, n: exponent(r, n, 0.2),
    "exponent, mixed model": mixed,
    "ratio of geometric means, paired t": ratio,
    "ratio of geometric means, 20 % zeros at another amplitude": lambda r, n: ratio(r, n, 0.2),
    "reliability (ICC), jackknife": icc,
    "d′ = 1, 3 steps and 1 catch step": d_prime(1.0, 3, 1),
    "d′ = 2, 3 steps and 1 catch step": d_prime(2.0, 3, 1),
    "d′ = 3, 3 steps and 1 catch step": d_prime(3.0, 3, 1),
    "d′ = 2 (between-person SD 0.4), 10 steps and 10 catch steps": d_prime(2.0, 10, 10, 0.4),
    "proportion of “yes” .9, one answer each": share(0.9, 1, 0.3),
    "exponent difference between two groups of n, Welch": group_gap,
    "two groups of n, Hedges' g, SDs 1.2 and 0.8": group_effect_size,
    "50 % “yes” point, Fieller, 4 sizes, 3 answers each": half_yes("removed_level"),
    "individual threshold, 4 sizes, n answers each (one participant)": own_threshold,
    "proportion of “yes” .5, 10 answers each, correlation .3": share(0.5, 10, 0.3),
    "proportion of “yes” .9, 10 answers each, correlation .3": share(0.9, 10, 0.3),
}
ERRORS: dict[str, Trial] = {
    "repeated-measures ANOVA, Greenhouse-Geisser": errs("anova"),
    "Friedman": errs("friedman"),
    "Wilcoxon, any of 6 pairs, Holm": errs("wilcoxon"),
    "paired t, any of 6 pairs, Holm": errs("t"),
    "declared equivalent at the bound, one pair": equal_errs,
    "growth in two groups of n, mixed ANOVA": group_errs,
    "drift in the presence of carry-over": order_errs("log_slope_per_trial", carry=0.3),
    "carry-over in the presence of drift": order_errs("log_slope_per_level_before", drift=0.05),
}


def measure(trial: Trial, n: int, studies: int, seed: int) -> str:
    """Return the proportion of studies, ".95", and their number if some had no result."""
    found = [trial(np.random.default_rng([seed, n, number]), n) for number in range(studies)]
    usable = [one for one in found if one is not None]
    if not usable:
        return "–"
    text = f"{np.mean(usable):.2f}".removeprefix("0")
    return text if len(usable) == studies else f"{text} ({len(usable)})"


def table(title: str, trials: dict[str, Trial], studies: int, seed: int) -> list[str]:
    """Measure and print the rows of a table; return its lines."""
    lines = [f"| {title} | n = {', '.join(map(str, SIZES))} |", "| --- | --- |"]
    for name, trial in trials.items():
        start = time.perf_counter()
        fewer = studies // SLOW.get(name, 1)
        row = ", ".join(measure(trial, n, fewer, seed) for n in SIZES)
        told = f" ({fewer} studies)" if name in SLOW else ""
        lines.append(f"| {name}{told} | {row} |")
        print(lines[-1], f"{time.perf_counter() - start:.1f} s", flush=True)
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--studies",
        type=int,
        default=200,
        help=("number of simulated studies per cell (default: 200)"),
    )
    parser.add_argument("--seed", type=int, default=13, help="random seed (default: 13)")
    parser.add_argument("--write", action="store_true", help="put the tables into the page")
    args = parser.parse_args()
    warnings.filterwarnings("ignore")  # statsmodels warns of fits that the analysis checks itself.
    # statsmodels' Holm correction collects garbage at each call. Without this line, collection
    # takes longer than the simulation of a study.
    gc.freeze()
    size = f"{args.studies} simulated studies unless stated otherwise (seed {args.seed})"
    lines = [f"Each cell is based on {size}.", ""]
    lines += table("Coverage of 95 % intervals", COVERAGE, args.studies, args.seed)
    lines += ["", *table("Error rate of tests at .05", ERRORS, args.studies, args.seed)]
    if args.write:
        put("coverage", lines)


if __name__ == "__main__":
    main()
