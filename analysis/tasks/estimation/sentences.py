"""Write sentences on results of magnitude estimation, in APA style (7th edition)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.mixed_model import BOUND_SENTENCE, MixedModel
from slipscale.analysis.statistics.not_computed import missing
from slipscale.analysis.writing.numbers import (
    bracketed,
    joined,
    level_of,
    number,
    of_size,
    p_value,
    unit_number,
)
from slipscale.analysis.writing.verdicts import DEPENDED, DIFFERED, page_sentence, reliable, verdict
from slipscale.stimuli.quantity import Quantity, capitalised

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
    from slipscale.analysis.statistics.power_law import PowerLaw
    from slipscale.analysis.statistics.reliability import Reliability
    from slipscale.analysis.statistics.repeated_measures.omnibus import (
        Friedman,
        LinearTrend,
        PageTrend,
        RmAnova,
    )
    from slipscale.analysis.statistics.repeated_measures.pairwise import PairComparison, PairedT
    from slipscale.analysis.tasks.estimation.growth.bayesian_growth import BayesianGrowth
    from slipscale.analysis.tasks.estimation.growth.statistics import Growth
    from slipscale.analysis.tasks.estimation.order_effects import OrderEffects
    from slipscale.analysis.tasks.estimation.robust_exponent import RobustExponent

#: Names of growth functions in sentences, keyed as in
#: `slipscale.analysis.tasks.estimation.growth.growth_models.MODELS`.
MODEL_NAMES = {
    "power": "Stevens's power law",
    "threshold": "the power law with a threshold",
    "linear": "the straight line",
    "fechner": "Fechner's law",
    "ekman": "Ekman's function",
    "naka_rushton": "the Naka–Rushton function",
}


#: Largest number of means, or of non-significant pairs, that a sentence lists.
MOST_LISTED = 6
#: Bayes factors above this value are reported as "> 100", below its reciprocal as "< 0.01".
MOST_DECISIVE = 100.0


#: Posterior predictive check -> description with a placeholder for the quantity ``q``.
CHECKS = {
    "curvature": "the curvature on logarithmic axes",
    "largest_residual": "the largest residual",
    "kurtosis": "the residuals' tails",
    "spread_ratio": "the ratio of the residuals' spreads at the largest and smallest {q.level}",
}
#: A posterior predictive p-value this close to 0 or 1 indicates that the model does not fit.
UNLIKELY = 0.025


def _ci(
    bounds: ConfidenceInterval | None,
    confidence: float,
    write: Callable[[float], str] = number,
) -> str:
    """Format an interval as ", 95% CI [low, high]"; return an empty string for None."""
    return "" if bounds is None else f", {level_of(confidence)} CI {bracketed(bounds, write)}"


def _degrees(df: float, epsilon: float) -> str:
    corrected = df * epsilon
    return f"{corrected:.2f}" if epsilon < 1 else f"{df:g}"


def rm_anova(found: RmAnova, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on the repeated-measures ANOVA."""
    epsilon = found.epsilon_gg
    verb = verdict(DIFFERED, found.p_gg, confidence, found.df2 * epsilon)
    ci = _ci(found.eta2_generalised_interval, confidence, unit_number)
    correction = f"; Greenhouse-Geisser ε = {unit_number(epsilon)}" if found.df1 > 1 else ""
    which = quantity.levels
    if found.left_out_levels:
        left = ", ".join(f"{amplitude:g}" for amplitude in found.left_out_levels)
        which = f"{which} (without {quantity.value(left)}, where every estimate is zero)"
    return (
        f"Log-transformed estimates {verb} between {which}, "
        f"F({_degrees(found.df1, epsilon)}, {_degrees(found.df2, epsilon)}) = "
        f"{number(found.F)}, {p_value(found.p_gg)}, generalised η² = "
        f"{unit_number(found.eta2_generalised)}{ci} ({_of(found.n, found.n_incomplete)}"
        f"{correction})."
    )


def friedman(found: Friedman, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on Friedman's test."""
    verb = verdict(DIFFERED, found.p, confidence, found.n - 1)
    return (
        f"Estimates {verb} between {quantity.levels} (Friedman's test on ranks, "
        f"χ²({found.df}, n = {found.n}) = {number(found.chi2)}, {p_value(found.p)}, Kendall's W = "
        f"{unit_number(found.kendalls_w)})."
    )


def page_trend(found: PageTrend, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on Page's test."""
    return page_sentence("Estimates", found, confidence, quantity.name, quantity)


def linear_trend(found: LinearTrend, confidence: float, quantity: Quantity) -> str | None:
    """Return a sentence on the linear contrast, or None if its slope was not tested."""
    slope = found.log_slope_per_level
    if not slope:
        return None
    write = of_size(slope.mean)
    return (
        f"The linear trend of log estimates was {write(slope.mean)} {quantity.per}, "
        f"{level_of(confidence)} CI {bracketed(slope.interval, write)}, t({slope.df}) = "
        f"{number(slope.t)}, {p_value(slope.p)} (n = {found.n})."
    )


def geometric_means(description: pd.DataFrame, quantity: Quantity) -> str:
    """Return a sentence that lists the geometric means (if many, only the first and the last)."""
    names = ["geometric_mean", "level", "geometric_n", "n"]
    rows = description[names].dropna().to_numpy(float).tolist()
    shown = rows if len(rows) <= MOST_LISTED else [rows[0], rows[-1]]
    listed = joined(
        [
            f"{number(mean)} at {quantity.value(level)}"
            + (f" (n = {n:g} of {people:g}, without estimates of zero)" if n < people else "")
            for mean, level, n, people in shown
        ]
    )
    if len(rows) == 1:
        return f"The geometric mean of {quantity.judged} was {listed}."
    return f"Geometric means of {quantity.judged} were {listed}."


def power_law(found: PowerLaw, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on the exponent."""
    return (
        f"The mean exponent of participants' power functions of {quantity.name} was "
        f"{number(found.exponent)}, {level_of(confidence)} CI {bracketed(found.interval)} (n = "
        f"{found.n}; {found.points} {quantity.levels} above {quantity.value(0)})."
    )


def robust_exponent(found: RobustExponent, confidence: float, _quantity: Quantity) -> str:
    """Return a sentence on the robust exponent."""
    return (
        f"A robust estimate of the exponent, which gives little weight to lapses and outliers, "
        f"was {number(found.exponent)}{_ci(found.interval, confidence)} (n = {found.n})."
    )


def pairwise_logs(
    pairs: Sequence[PairComparison], confidence: float, quantity: Quantity
) -> str | None:
    """Return a sentence on the paired t tests of all pairs."""
    tested = [(pair, pair.logs) for pair in pairs if pair.logs]
    if len(pairs) == len(tested) == 1:
        only = tested[0][1]
        verb = verdict(DIFFERED, only.p, confidence, only.df)
        return (
            f"Log estimates {verb} between the two {quantity.levels}, t({only.df}) = "
            f"{number(only.t)}, {p_value(only.p)}, d_z = {number(only.d_z)}"
            f"{_ci(only.d_z_interval, confidence)}."
        )
    untested = "; ".join(
        f"{_pair(pair, quantity)} ({lacking.reason})"
        for pair in pairs
        for lacking in missing([pair.logs])
    )
    behind = f" Pairs whose log estimates were not tested: {untested}." if untested else ""
    if not tested:
        return behind.strip()
    rows = [(pair, found.p_holm, pair.n_logs) for pair, found in tested]
    how = ("Log estimates", "paired t tests")
    return _all_pairs(rows, how, 0.0, confidence, quantity) + behind


def equivalence(
    pairs: Sequence[PairComparison], confidence: float, quantity: Quantity
) -> str | None:
    """Return a sentence on the equivalence of pairs that do not differ significantly.

    Returns None if all pairs differ.
    """
    apart = [
        (pair, pair.logs)
        for pair in pairs
        if pair.logs and not reliable(pair.logs.p_holm, confidence)
    ]
    if not apart:
        return None
    equal, undecided = (
        "; ".join(
            _equivalence(pair, logs, quantity)
            for pair, logs in apart
            if reliable(logs.equivalence_p_holm, confidence) == wanted
        )
        for wanted in (True, False)
    )
    how = (
        "two one-sided paired t tests of log estimates"
        + (", Holm-corrected" if len(pairs) > 1 else "")
        + f"; equivalence bound: a ratio of {apart[0][1].equivalence.bound:g}"
        + "; BF₀₁: Bayes factor in favour of no difference"
    )
    parts = [f"Pairs that were equivalent: {equal or 'none'}"]
    parts += [f"pairs that neither differed nor were equivalent: {undecided}"] if undecided else []
    return f"{'; '.join(parts)} ({how})."


def _equivalence(pair: PairComparison, logs: PairedT, quantity: Quantity) -> str:
    bounds = logs.equivalence.interval
    return (
        f"{_pair(pair, quantity)}, ratio {number(logs.ratio)}, {level_of(bounds.confidence)} CI "
        f"{bracketed(bounds)}, {p_value(logs.equivalence_p_holm)}, "
        f"BF₀₁ {bayes_of_none(logs.bayes_factor)} (n = {pair.n_logs})"
    )


def bayes_of_none(for_a_difference: float) -> str:
    """Format the Bayes factor in favour of no difference, preceded by "=", "<" or ">".

    >>> bayes_of_none(0.236), bayes_of_none(float("inf")), bayes_of_none(0.0001)
    ('= 4.24', '< 0.01', '> 100')
    """
    if for_a_difference > MOST_DECISIVE:
        return f"< {1 / MOST_DECISIVE:g}"
    if for_a_difference * MOST_DECISIVE < 1:
        return f"> {MOST_DECISIVE:g}"
    return f"= {number(1 / for_a_difference)}"


def pairwise_ranks(
    pairs: Sequence[PairComparison], confidence: float, quantity: Quantity
) -> str | None:
    """Return a sentence on the Wilcoxon tests of all pairs."""
    rows = [(pair, pair.ranks.p_holm, pair.n) for pair in pairs if isfinite(pair.ranks.p)]
    if not rows:
        return f"Estimates were the same at all {quantity.levels}, so no pair was tested."
    if len(pairs) == 1:
        pair, ranks = pairs[0], pairs[0].ranks
        df = pair.n - 1 if reliable(_least_rank_p(pairs), confidence) else 0
        verb = verdict(DIFFERED, ranks.p, confidence, df)
        return (
            f"Estimates {verb} between the two {quantity.levels} (Wilcoxon signed-rank test, "
            f"{p_value(ranks.p)}; of {pair.n} participants, {ranks.up} gave higher and "
            f"{ranks.down} gave lower estimates at {quantity.value(pair.to_level)})."
        )
    untested = len(pairs) - len(rows)
    behind = f" Pairs with the same estimates, which were not tested: {untested}."
    how = ("Estimates", "Wilcoxon signed-rank tests")
    found = _all_pairs(rows, how, _least_rank_p(pairs), confidence, quantity)
    return found + (behind if untested else "")


def out_of_reach(
    pairs: Sequence[PairComparison], confidence: float, quantity: Quantity
) -> list[str]:
    """Return a warning if no Wilcoxon test can be significant with this number of participants."""
    least = _least_rank_p(pairs)
    if reliable(least, confidence):
        return []
    return [
        (
            f"There are too few participants for Wilcoxon tests of {quantity.levels}: even if all "
            "estimates differ in the same direction, the smallest possible Holm-corrected p is "
            f"{unit_number(least, 3)}. Results that are not significant are not evidence of "
            "equality."
        )
    ]


def _least_rank_p(pairs: Sequence[PairComparison]) -> float:
    """Return the smallest Holm-corrected p that the Wilcoxon tests can have; 0 without tests."""
    # Equal estimates are left out. If all n differences have one sign, the exact p is 2 / 2^n.
    ns = [pair.ranks.up + pair.ranks.down for pair in pairs if isfinite(pair.ranks.p)]
    return min((min(1.0, len(ns) * 2.0 ** (1 - n)) for n in ns), default=0.0)


def _pair(pair: PairComparison, quantity: Quantity) -> str:
    return f"{pair.from_level:g} and {quantity.value(pair.to_level)}"


def _of(n: int, incomplete: int) -> str:
    """Return "n = 12", or "n = 12 of 14" if participants are excluded."""
    return f"n = {n}" + (f" of {n + incomplete}" if incomplete else "")


def _all_pairs(
    rows: Sequence[tuple[PairComparison, float, int]],
    names: tuple[str, str],
    least: float,
    confidence: float,
    quantity: Quantity,
) -> str:
    """Return a sentence on all pairs: ``names`` of the values and the test, its ``least`` p."""
    what, test = names
    doubtful = [row for row in rows if not reliable(row[1], confidence)]
    counts = sorted({n for _, _, n in rows})
    people = f"n = {counts[0]}" + (f" to {counts[-1]}" if len(counts) > 1 else "")
    how = f"{test}, Holm-corrected, {people}"
    if not doubtful:
        largest = p_value(max(p for _, p, _ in rows)).replace("=", "≤")
        many = {1: "one pair", 2: "both pairs"}.get(len(rows), f"all {len(rows)} pairs")
        return f"{what} {DIFFERED.past} for {many} of {quantity.levels} ({how}, all {largest})."
    smallest = p_value(min(p for _, p, _ in doubtful)).replace("=", "≥")
    if len(doubtful) == len(rows):
        many = f"any of the {len(rows)} pairs" if len(rows) > 1 else "the one pair tested"
        df = counts[0] - 1 if reliable(least, confidence) else 0
        verb = verdict(DIFFERED, min(p for _, p, _ in doubtful), confidence, df)
        return f"{what} {verb} for {many} of {quantity.levels} ({how}, all {smallest})."
    told = f"{what} {DIFFERED.past} for {len(rows) - len(doubtful)} of the {len(rows)} pairs"
    listed = joined([f"{_pair(pair, quantity)} ({p_value(p)}, n = {n})" for pair, p, n in doubtful])
    if len(doubtful) > MOST_LISTED:
        listed = f"the other {len(doubtful)} pairs (all {smallest})"
    return f"{told} of {quantity.levels} ({how}). No difference was shown for {listed}."


def growth(found: Growth, _confidence: float, _quantity: Quantity) -> str:
    """Return a sentence on the comparison of growth functions."""
    compared = found.of_level
    models, best = compared.models, compared.best
    others = sorted(
        (model.delta_aicc, name)
        for name, model in models.items()
        if name != best and model.delta_aicc is not None
    )
    delta, second = others[0] if others else (None, "")
    then = f"; {MODEL_NAMES[second]} is next, ΔAICc = {number(delta, 1)}" if second else ""
    bounds = [
        f"the {parameter.replace('_', ' ')} of {MODEL_NAMES[name]}"
        for name, model in models.items()
        for parameter in model.fit.at_bound
    ]
    behind = (
        f" {capitalised(joined(bounds))} could not be determined, because the fit reached the "
        "search limit."
        if bounds
        else ""
    )
    weight = f"Akaike weight {unit_number(models[best].weight)}"
    if compared.undecided:
        return (
            f"The data do not discriminate between growth functions: {MODEL_NAMES[best]} has the "
            f"lowest AICc, but by less than 2 ({weight}{then}).{behind}"
        )
    return f"Among the growth functions, {MODEL_NAMES[best]} fits best ({weight}{then}).{behind}"


def bayesian_growth(found: BayesianGrowth, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on the hierarchical power function, with numbers only if it converged."""
    if not found.converged:
        return (
            "The hierarchical Bayesian power function did not converge (largest R̂ = "
            f"{number(found.r_hat, 3)}, {found.divergences} divergences); its estimates are not "
            "reported."
        )
    level = level_of(confidence)
    missed = [
        f"{CHECKS[name].format(q=quantity)} (posterior predictive p = {unit_number(check.p, 3)})"
        for name, check in found.checks.items()
        if min(check.p, 1 - check.p) < UNLIKELY
    ]
    fits = (
        f"the model's predictions do not agree with the data in {joined(missed)}"
        if missed
        else "the model's predictions agree with the data in "
        + joined([CHECKS[name].format(q=quantity) for name in found.checks])
    )
    return (
        f"A hierarchical Bayesian power function gave an exponent of {number(found.exponent)}, "
        f"{level} credible interval {bracketed(found.interval)}; participants' exponents have a "
        f"standard deviation of {number(found.sd_exponent)}, {level} credible interval "
        f"{bracketed(found.sd_exponent_interval)}, and shrink by {100 * found.shrinkage:.0f}% "
        f"towards the group exponent (n = {found.n}, {found.trials} trials; {fits})."
    )


def order(found: OrderEffects, confidence: float, quantity: Quantity) -> str | None:
    """Return a sentence on order effects and carry-over."""
    effects: dict[str, list[str]] = {}
    for slope, words in (
        (found.log_slope_per_trial, "trial position"),
        (found.log_slope_per_level_before, f"the preceding {quantity.stimulus}"),
    ):
        if not slope:
            continue
        verb = verdict(DEPENDED, slope.p, confidence, slope.df)
        effects.setdefault(verb, []).append(
            f"on {words}, t({slope.df}) = {number(slope.t)}, {p_value(slope.p)}"
        )
    texts = [
        f"{verb} {(', and ' if verb == DEPENDED.past else ', or ').join(parts)}"
        for verb, parts in effects.items()
    ]
    return f"Estimates {'; they '.join(texts)}." if texts else None


def reliability(found: Reliability, confidence: float, _quantity: Quantity) -> str:
    """Return a sentence on test-retest reliability."""
    single, mean = found.single, found.mean
    return (
        "Test-retest reliability of single log estimates was ICC = "
        f"{unit_number(single.value)}{_ci(single.interval, confidence, unit_number)}; for means of "
        f"{found.repetitions:.3g} estimates, "
        f"{unit_number(mean.value)}{_ci(mean.interval, confidence, unit_number)} (by "
        f"{found.method}, {found.trials} trials from {found.n} participants)."
    )


def mixed_model(found: MixedModel, confidence: float, _quantity: Quantity) -> str:
    """Return a sentence on the mixed model, with numbers only if the fit converged."""
    if not found.converged:
        return (
            "The linear mixed model with random intercepts and slopes did not converge; its "
            "exponent is not reported."
        )
    bound = f"; {BOUND_SENTENCE}" if found.at_bound else ""
    return (
        "A power function fitted to all trials, with random effects of participants on level and "
        "exponent (a linear mixed model of logarithms), gave an exponent of "
        f"{number(found.exponent)}{_ci(found.interval, confidence)} ({found.trials} trials from "
        f"{found.n} participants{bound})."
    )
