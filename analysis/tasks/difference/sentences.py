"""Write sentences on the descending difference task in APA style (7th edition)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from math import isfinite
from statistics import median
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    bracketed,
    joined,
    level_of,
    number,
    of_size,
    p_value,
)
from slipscale.analysis.writing.verdicts import DEPENDED, reliable, verdict
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    from slipscale.analysis.tasks.difference.probit import DPrimeOfSize
    from slipscale.analysis.tasks.difference.step_size_curve import PsychometricCurve
    from slipscale.analysis.tasks.difference.yes_no import (
        DescendingDifference,
        Finding,
        Sensitivity,
        SignalDetection,
    )


def _measured(
    found: PsychometricCurve, quantity: Quantity
) -> tuple[str, str, Callable[[str], str]]:
    """Return the name, the unit and a formatting function for the measure of step size."""
    if found.measure == "weber_fraction":
        return (
            f"the step's Weber fraction (its size divided by the {quantity.name} before it)",
            "per unit" if found.axis == "linear" else "per natural logarithm",
            "a Weber fraction of {}".format,
        )
    removed = f"{quantity.per} removed" if quantity.stepped else quantity.per
    if found.axis == "logarithmic":
        removed = "per natural logarithm of the level"
    return quantity.yes_no.size, removed, quantity.value


def psychometric(
    found: PsychometricCurve | NotComputed, confidence: float, quantity: Quantity
) -> str:
    """Return a sentence on the curve of "yes" answers against step size."""
    if isinstance(found, NotComputed):
        size = quantity.yes_no.size
        return f"No curve of “{quantity.yes}” against {size} was fitted: {found.reason}."
    verb = verdict(DEPENDED, found.p, confidence, found.df)
    size, per, written = _measured(found, quantity)
    level = level_of(confidence)
    write = of_size(found.log_odds_per_unit)
    half = ""
    if found.half_yes_between:
        gap = _between(found.half_yes_between, written)
        half = f"; half of the answers were “{quantity.yes}” {gap}"
    elif found.half_yes is not None and found.half_yes > 0:
        own = of_size(found.half_yes)
        bounds = (
            "with an unbounded confidence interval"
            if found.half_yes_interval is None
            else f"{level} CI {bracketed(found.half_yes_interval, own)}"
        )
        at = written(own(found.half_yes))
        half = f"; half of the answers were “{quantity.yes}” at {at}, {bounds}"
    what = f"The probability of “{quantity.yes}”"
    lead = f"{what} {verb} on {size}: "
    if found.own_z and not reliable(found.p, confidence):
        lead = _of_few(found, confidence, what, size)
    return (
        f"{lead}the slope of the log odds was "
        f"{write(found.log_odds_per_unit)} {per}, {level} CI "
        f"{bracketed(found.interval, write)}, t({found.df}) = {number(found.t)}, "
        f"{p_value(found.p)}{half} ({found.answers} answers from {found.n} participants; "
        f"{found.axis} axis)."
    )


def _of_few(found: PsychometricCurve, confidence: float, what: str, size: str) -> str:
    """Return each participant's result, because so few people do not represent a population."""
    from scipy import special

    least = float(special.ndtri((1 + confidence) / 2))
    zs = sorted(found.own_z.values())
    rose, fell = sum(z > least for z in zs), sum(z < -least for z in zs)
    fallen = f" and fell in {fell}" if fell else ""
    return (
        f"{what} rose with {size} in {rose}{fallen} of {found.n} participants (z of "
        f"their own logistic curves: {number(zs[0])} to {number(zs[-1])}). Whether it does so in a "
        "population cannot be tested with so few participants. In the curve of all participants, "
    )


def _between(gap: tuple[float, float], written: Callable[[str], str]) -> str:
    low, high = gap
    return f"between {of_size(high)(low)} and {written(of_size(high)(high))}"


def own_thresholds(found: DescendingDifference, quantity: Quantity) -> list[str]:
    """Return sentences on individual thresholds and on the reasons why there are none."""
    own = [one for one in found.thresholds.values() if one]
    reasons = Counter(
        one.reason for one in found.thresholds.values() if isinstance(one, NotComputed)
    )
    texts = [
        f"{times} of {len(found.thresholds)} participants have no individual threshold: {reason}."
        for reason, times in reasons.items()
        if own or not reason.startswith("too few")
    ]
    if own:
        write = quantity.value
        values = sorted(one.threshold_level.value for one in own)
        texts.insert(
            0,
            f"Individual thresholds, available for {len(own)} of {len(found.thresholds)} "
            f"participants, range from {number(values[0])} to {write(number(values[-1]))} with a "
            f"median of {write(number(median(values)))} (logistic curves on a "
            f"{'logarithmic' if CURVES[own[0].curve].logarithmic else 'linear'} axis with "
            "individual lapse rates, and false-alarm rates from catch trials; individuals.csv "
            "lists their intervals).",
        )
    return texts


def _of_one(found: DescendingDifference, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on the threshold of the only participant, or why there is none."""
    ((who, own),) = found.thresholds.items()
    if isinstance(own, NotComputed):
        return f"No threshold of {who}, the only participant, was fitted: {own.reason}."
    at = own.threshold_level
    axis = "logarithmic" if CURVES[own.curve].logarithmic else "linear"
    return (
        f"Threshold of {who}, the only participant: {quantity.value(number(at.value))}, "
        f"{level_of(confidence)} CI {bracketed(at.interval)} (logistic curve, {own.trials} "
        f"answers; {axis} axis). A curve of the population requires at least three participants."
    )


def finding(found: Finding, quantity: Quantity) -> str:
    """Return a sentence that compares the answers with the paper's finding.

    Verbal reports are mentioned only for slipperiness, because the codebook covers no other
    property.
    """
    n, fell = found.n, f"when the {quantity.name} fell"
    coded = quantity.judged == PLATE_AMPLITUDE.judged
    if n == 1:
        felt = "a difference" if found.felt_a_difference else "no difference"
        verb = "said" if found.said_less_slippery else "did not say"
        less = f", and {verb} that the surface became less slippery" if coded else ""
        return f"The only participant felt {felt} {fell}{less}."
    everyone = f"All {n}" if found.all_felt_a_difference else f"{found.felt_a_difference} of {n}"
    some = f"all {n}" if found.all_said_less_slippery else f"{found.said_less_slippery} of {n}"
    less = f", and {some} said that the surface became less slippery" if coded else ""
    return (
        f"{everyone} participants felt a difference {fell} ({found.felt_every_change} of {n} at "
        f"every step){less}."
    )


def answer(found: DescendingDifference, confidence: float, quantity: Quantity) -> list[str]:
    """Return a sentence with the main result: counts of participants, or the fitted curve.

    For stimuli other than plate amplitudes, the sentence describes the fitted curve.
    """
    if not quantity.stepped and found.participants == 1:
        return [_of_one(found, confidence, quantity)]
    if not quantity.stepped:
        return [psychometric(found.psychometric, confidence, quantity)]
    return [finding(found.finding, quantity)] if found.finding.n else []


def difference_sentences(
    found: DescendingDifference | NotComputed, confidence: float, quantity: Quantity
) -> list[str]:
    """Return the sentences on the descending difference task; empty if there is no result."""
    if not found:
        return []
    texts = answer(found, confidence, quantity)
    if quantity.stepped:
        texts.append(psychometric(found.psychometric, confidence, quantity))
        if found.weber:
            texts.append(psychometric(found.weber, confidence, quantity))
    if quantity.stepped or found.participants > 1:
        texts += own_thresholds(found, quantity)
    detection = found.signal_detection
    if isinstance(detection, NotComputed):
        texts.append(f"Sensitivity was not computed: {detection.reason}.")
        return texts
    pooled, words = detection.pooled, quantity.yes_no
    texts.append(
        f"The answer was “{quantity.yes}” for {pooled.hits} of {pooled.changes} "
        f"{words.trials[1]} and for {pooled.false_alarms} of {pooled.catches} {words.catch[1]}. "
        f"{sensitivity(detection, confidence, quantity)}"
    )
    return texts


def sensitivity(found: SignalDetection, confidence: float, quantity: Quantity) -> str:
    """Return a sentence on d' for each step size."""
    if isinstance(found.by_size, NotComputed):
        return f"d′ was not computed: {found.by_size.reason}."
    sizes: dict[str, list[str]] = {}
    for each in found.by_size:
        sizes.setdefault(_d_prime(each, found.pooled, quantity), []).append(
            f"{each.removed_level:g}"
        )
    text = ", and ".join(
        f"{d_prime} {quantity.yes_no.at} {quantity.value(joined(same))}"
        for d_prime, same in sizes.items()
    )
    limits = "" if "[" in text else "limits of "
    level = f" ({limits}{level_of(confidence)} intervals)" if "d′" in text else ""
    mean = found.mean_d_prime
    open_end = ""
    if mean and not (isfinite(mean.interval.low) and isfinite(mean.interval.high)):
        open_end = " (without a bound where a participant made no error)"
    own = (
        ""
        if not mean
        else f" The mean of individual d′ values was {number(mean.mean)}, "
        f"{level_of(confidence)} CI {bracketed(mean.interval)}{open_end}."
    )
    return f"Sensitivity was {text}{level}.{own}"


def _d_prime(found: DPrimeOfSize, pooled: Sensitivity, quantity: Quantity) -> str:
    low, high = found.interval
    if not isfinite(low) and not isfinite(high):
        return f"undetermined ({_why_undetermined(found, pooled, quantity)})"
    if not isfinite(high):
        return f"at least d′ = {number(low)}"
    if not isfinite(low):
        return f"at most d′ = {number(high)}"
    return f"d′ = {number(found.d_prime)} {bracketed(found.interval)}"


def _why_undetermined(found: DPrimeOfSize, pooled: Sensitivity, quantity: Quantity) -> str:
    both = f"these answers and the answers to {quantity.yes_no.catch[1]}"
    if (found.yes, pooled.false_alarms) == (found.steps, pooled.catches):
        return f"all of {both} were “{quantity.yes}”"
    if not found.yes and not pooled.false_alarms:
        return f"none of {both} was “{quantity.yes}”"
    return "too few answers"
