"""The sentences a results section needs, numbers filled in, in APA style (7th edition).

Each writer takes a result and returns its sentence.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from analysis.reporting.numbers import bracketed, number, p_value, unit_number
from analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from analysis.statistics.confidence_interval import ConfidenceInterval
    from analysis.statistics.growth import Growth
    from analysis.statistics.mixed_model import MixedModel
    from analysis.statistics.omnibus import Friedman, LinearTrend, PageTrend, RmAnova
    from analysis.statistics.order_and_reliability import OrderEffects, Reliability
    from analysis.statistics.pairwise import PairComparison
    from analysis.statistics.power_law import PowerLaw
    from analysis.statistics.psychometric import PsychometricCurve
    from analysis.statistics.run_all import Inference
    from analysis.statistics.yes_no import DescendingDifference, Finding

T = TypeVar("T")

#: Sentences call reliable what has a p below this.
RELIABLE = 0.05
#: What `analysis.statistics.growth_models.MODELS` are called in a sentence.
MODEL_NAMES = {
    "power": "Stevens's power law",
    "threshold": "the power law with a threshold",
    "linear": "the straight line",
    "fechner": "Fechner's law",
}


def _ci(
    bounds: ConfidenceInterval | None, level: str, write: Callable[[float], str] = number
) -> str:
    """Return ", 95% CI [low, high]", or nothing where it is not defined."""
    return "" if bounds is None else f", {level} CI {bracketed(bounds, write)}"


def _degrees(df: float, epsilon: float) -> str:
    corrected = df * epsilon
    return f"{corrected:.2f}" if epsilon < 1 else f"{df:g}"


def rm_anova(found: RmAnova, level: str) -> str:
    """Return the sentence of the repeated-measures ANOVA, corrected where sphericity fails."""
    epsilon, p, sphericity = 1.0, found.p, ""
    if found.mauchly_w is not None and found.mauchly_p is not None and found.mauchly_p < RELIABLE:
        epsilon, p = found.epsilon_gg, found.p_gg
        sphericity = (
            f" (Greenhouse-Geisser correction, ε = {unit_number(found.epsilon_gg)}; Mauchly's "
            f"W = {unit_number(found.mauchly_w, 3)}, {p_value(found.mauchly_p)})"
        )
    verb = "differed" if p < RELIABLE else "did not differ reliably"
    ci = _ci(found.eta2_generalised_interval, level, unit_number)
    return (
        f"Log-transformed estimates {verb} between amplitudes, "
        f"F({_degrees(found.df1, epsilon)}, {_degrees(found.df2, epsilon)}) = "
        f"{number(found.F)}, {p_value(p)}, generalised η² = "
        f"{unit_number(found.eta2_generalised)}{ci}{sphericity}."
    )


def friedman(found: Friedman, _level: str) -> str:
    """Return the sentence of Friedman's test."""
    return (
        f"Friedman's test on the ranks gave χ²({found.df}, N = {found.n}) = "
        f"{number(found.chi2)}, {p_value(found.p)}, Kendall's W = "
        f"{unit_number(found.kendalls_w)}."
    )


def page_trend(found: PageTrend, _level: str) -> str:
    """Return the sentence of Page's test."""
    verb = "grew" if found.p < RELIABLE else "did not grow reliably"
    return (
        f"Estimates {verb} with amplitude (Page's L = {found.L:g}, {p_value(found.p)}, one-sided)."
    )


def linear_trend(found: LinearTrend, level: str) -> str | None:
    """Return the sentence of the linear contrast; None where its slope was not tested."""
    slope = found.log_slope_per_um_pp
    if isinstance(slope, NotComputed):
        return None
    return (
        f"The linear trend of log estimates was {number(slope.mean)} per µm (peak to peak), "
        f"{level} CI {bracketed(slope.interval)}, t({slope.df}) = {number(slope.t)}, "
        f"{p_value(slope.p)}."
    )


def power_law(found: PowerLaw, level: str) -> str:
    """Return the sentence of the exponent."""
    return (
        f"The exponents of participants' power functions of amplitude averaged "
        f"{number(found.exponent)}, {level} CI "
        f"{bracketed(found.interval)} (n = {found.n}; {found.points} "
        "amplitudes above 0 µm; Student's interval over participants)."
    )


def pairwise(pairs: Sequence[PairComparison], level: str) -> str | None:
    """Return one sentence on all pairs."""
    tested = [(pair, pair.logs) for pair in pairs if not isinstance(pair.logs, NotComputed)]
    if len(pairs) == len(tested) == 1:
        only = tested[0][1]
        verb = "differed" if only.p < RELIABLE else "did not differ reliably"
        return (
            f"The two amplitudes {verb}, t({only.df}) = {number(only.t)}, {p_value(only.p)}, "
            f"d_z = {number(only.d_z)}{_ci(only.d_z_interval, level)}."
        )
    reliable = sum(found.p_holm < RELIABLE for _, found in tested)
    # A p that is not defined is not reliable.
    doubtful = [(pair, found) for pair, found in tested if not found.p_holm < RELIABLE]

    def words(pair: PairComparison) -> str:
        return f"{pair.from_um_pp:g} and {pair.to_um_pp:g} µm"

    # Where every participant has the same difference, there is no t to judge it by.
    untested = "; ".join(words(pair) for pair in pairs if isinstance(pair.logs, NotComputed))
    behind = f" Without spread between participants, not tested: {untested}." if untested else ""
    if not tested:
        return behind.strip()
    if not doubtful:
        largest = p_value(max(found.p_holm for _, found in tested)).replace("=", "≤")
        many = f"All {len(tested)} pairs" if len(tested) > 1 else "One pair"
        return f"{many} of amplitudes differed (Holm-corrected, every {largest}).{behind}"
    listed = "; ".join(f"{words(pair)}, {p_value(found.p_holm)}" for pair, found in doubtful)
    start = (
        f"{reliable} of {len(tested)} pairs of amplitudes differed (Holm-corrected)"
        if reliable
        else f"None of {len(tested)} pairs of amplitudes differed (Holm-corrected)"
    )
    return f"{start}; not told apart: {listed}.{behind}"


def growth(found: Growth, _level: str) -> str:
    """Return the sentence of the model comparison."""
    models, best = found.amplitude.models, found.amplitude.best
    others = sorted(
        (model.delta_aicc, name)
        for name, model in models.items()
        if name != best and model.delta_aicc is not None
    )
    listed = ", ".join(f"{MODEL_NAMES[name]} ΔAICc = {number(delta, 1)}" for delta, name in others)
    return (
        f"Among growth functions, {MODEL_NAMES[best]} was favoured (Akaike weight "
        f"{unit_number(models[best].weight)}; {listed})."
    )


def order(found: OrderEffects, _level: str) -> str | None:
    """Return the sentence on order and carry-over."""
    texts = []
    for slope, words in (
        (found.log_slope_per_trial, "the trial's position"),
        (found.log_slope_per_um_pp_before, "the surface before"),
    ):
        if isinstance(slope, NotComputed):
            continue
        verb = "depended" if slope.p < RELIABLE else "did not depend reliably"
        texts.append(
            f"estimates {verb} on {words}, t({slope.df}) = {number(slope.t)}, {p_value(slope.p)}"
        )
    if not texts:
        return None
    text = "; ".join(texts)
    return text[0].upper() + text[1:] + "."


def reliability(found: Reliability, _level: str) -> str:
    """Return the sentence on test-retest reliability."""
    icc = found.icc["ICC2"]
    return (
        f"Test-retest reliability of single log estimates over {found.repetitions} repetitions "
        f"was ICC(A,1) = {unit_number(icc.value)}, 95% CI {bracketed(icc.interval, unit_number)} "
        f"(over {found.targets} pairs of participant and amplitude, so that differences between "
        "amplitudes count as reliable)."
    )


def mixed_model(found: MixedModel, level: str) -> str:
    """Return the sentence of the mixed model; its numbers only where the fit converged."""
    if not found.converged:
        return (
            "The linear mixed model with random intercepts and slopes did not converge; its "
            "exponent is not reported."
        )
    bound = (
        "; a variance or correlation of the random effects lies at its bound"
        if found.at_bound
        else ""
    )
    return (
        f"A linear mixed model with random intercepts and slopes gave an exponent of "
        f"{number(found.exponent)}, {level} CI {bracketed(found.interval)} (REML, {found.trials} "
        f"trials of {found.n} participants; Student's interval with {found.n - 1} degrees of "
        f"freedom{bound})."
    )


def sentences(inference: Inference, confidence: float = 0.95) -> list[str]:
    """Return the sentences on magnitude estimates, in the order of a results section."""
    level = f"{100 * confidence:g}%"

    def write(found: T | NotComputed, writer: Callable[[T, str], str | None]) -> str | None:
        return None if isinstance(found, NotComputed) else writer(found, level)

    written = [
        write(inference.rm_anova, rm_anova),
        write(inference.friedman, friedman),
        write(inference.page_trend, page_trend),
        write(inference.linear_trend, linear_trend),
        write(inference.pairwise, pairwise),
        write(inference.power_law, power_law),
        write(inference.mixed_model, mixed_model),
        write(inference.growth, growth),
        write(inference.order, order),
        write(inference.reliability, reliability),
    ]
    return [text for text in written if text]


def psychometric(found: PsychometricCurve | NotComputed, level: str) -> str:
    """Return the sentence of the curve of "yes" against the size of the step."""
    if isinstance(found, NotComputed):
        return f"No curve of “yes” against the size of the step was fitted: {found.reason}."
    verb = "depended" if found.p < RELIABLE else "did not depend reliably"
    half = (
        f"; half of the answers are “yes” at {number(found.half_yes_um_pp)} µm"
        if found.half_yes_um_pp is not None and found.half_yes_um_pp > 0
        else ""
    )
    return (
        f"“Yes” {verb} on the size of the step, log odds {number(found.log_odds_per_um_pp)} per µm "
        f"(peak to peak) removed, {level} CI {bracketed(found.interval)}, t({found.df}) = "
        f"{number(found.t)}, {p_value(found.p)}{half} (logistic curve by generalised "
        "estimating equations, answers of a participant exchangeable)."
    )


def finding(found: Finding) -> str:
    """Return the paper's finding: who felt a difference, and who said it was less slippery."""
    n = found.n
    if n == 1:
        felt = "a difference" if found.felt_a_difference else "no difference"
        said = "said" if found.said_less_slippery else "did not say"
        return (
            f"The one participant felt {felt} when the amplitude fell, and {said} that the surface "
            "became less slippery."
        )
    everyone = f"All {n}" if found.all_felt_a_difference else f"{found.felt_a_difference} of {n}"
    said = f"all {n}" if found.all_said_less_slippery else f"{found.said_less_slippery} of {n}"
    return (
        f"{everyone} participants felt a difference when the amplitude fell "
        f"({found.felt_every_change} of {n} at every step), and {said} said that the surface "
        "became less slippery."
    )


def difference_sentences(
    found: DescendingDifference | NotComputed, confidence: float = 0.95
) -> list[str]:
    """Return the sentences on the descending difference; none where it was not run."""
    if isinstance(found, NotComputed):
        return []
    level = f"{100 * confidence:g}%"
    texts = [finding(found.finding)] if found.finding.n else []
    texts.append(psychometric(found.psychometric, level))
    detection = found.signal_detection
    if isinstance(detection, NotComputed):
        texts.append(f"Sensitivity was not computed: {detection.reason}.")
        return texts
    pooled, mean = detection.pooled, detection.mean_d_prime
    spread = (
        ""
        if isinstance(mean, NotComputed)
        else f"; mean of participants {number(mean.mean)}, {level} CI {bracketed(mean.interval)}"
    )
    texts.append(
        f"“Yes” was said on {pooled.hits} of {pooled.changes} steps and on "
        f"{pooled.false_alarms} of {pooled.catches} catch steps; pooled "
        f"d′ = {number(pooled.d_prime)}, c = {number(pooled.criterion)} (log-linear "
        f"correction{spread})."
    )
    return texts
