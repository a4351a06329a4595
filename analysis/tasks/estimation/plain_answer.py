"""Answer the question of a magnitude estimation study in one sentence without test statistics."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from slipscale.analysis.preprocessing.normalisation import RULES
from slipscale.analysis.statistics.repeated_measures.pairwise import PairComparison
from slipscale.analysis.tasks.estimation.statistics import FRIEDMAN, PAIRWISE, RM_ANOVA
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing.numbers import grouped, joined, significant
from slipscale.analysis.writing.verdicts import DIFFERED, reliable
from slipscale.stimuli.quantity import capitalised

#: Means of at least this size are written without decimals.
LARGE = 10
#: If there are more neighbouring pairs without a difference, they are counted.
MOST_LISTED = 3


def plain_answer(analysis: Analysis) -> str:
    """Return the lowest and the highest mean, and whether the primary analysis found a difference.

    The means are those of the main figure. The sentence states a direction only if the primary
    analysis found a difference and the means are in order.
    """
    quantity, rule = analysis.dataset.quantity, RULES[analysis.rule]
    means = analysis.description.set_index("level")["mean"].dropna()
    levels = means.index.to_numpy(float)
    first, last = float(levels[0]), float(levels[-1])
    low, high = float(levels[means.argmin()]), float(levels[means.argmax()])
    write = _writer(means[low], means[high])
    unit = f" {rule.unit.format(q=quantity)}" if rule.end else ""
    what, between = f"mean {quantity.judged}", f"between {first:g} and {quantity.value(last)}"
    difference = _difference(analysis)
    if difference is None:
        ends = sorted({first, last})
        shown = joined([f"{write(means[each])} at {quantity.value(each)}" for each in ends])
        whole = f" ({unit.strip()})" if unit else ""
        none = "" if first == last else "; a difference could not be tested"
        return capitalised(f"{what} was {shown}{whole}{none}.")
    if not difference:
        return (
            f"No difference between {quantity.levels} was shown: {what} ranged from "
            f"{write(means[low])} to {write(means[high])}{unit} {between}."
        )
    if {low, high} == {first, last} and (
        means.is_monotonic_increasing or means.is_monotonic_decreasing
    ):
        verb = "rose" if high == last else "fell"
        scale = f"{write(means[first])} to {write(means[last])}{unit}"
        return capitalised(f"{what} {verb} from {scale} {between}{_steps(analysis)}.")
    return capitalised(
        f"{what} {DIFFERED.past} between {quantity.levels}: it was lowest at "
        f"{quantity.value(low)}, {write(means[low])}, and highest at {quantity.value(high)}, "
        f"{write(means[high])}{unit}{_steps(analysis)}."
    )


def _writer(low: float, high: float) -> Callable[[float], str]:
    """Return a function that formats means, with enough digits to distinguish two of them."""
    if high < LARGE:
        return significant
    decimals = 0 if round(low) < round(high) or low == high else 1
    return lambda mean: grouped(mean, decimals)


def _difference(analysis: Analysis) -> bool | None:
    """Return whether the primary analysis found any difference; None without a test."""
    inference, choices = analysis.inference, analysis.dataset.choices
    pairs = inference.found(PAIRWISE) or ()
    if len(pairs) == 1:
        p = _p_holm(pairs[0], analysis)
    elif choices.primary == "ranks":
        p = found.p if (found := inference.found(FRIEDMAN)) else None
    else:
        p = anova.p_gg if (anova := inference.found(RM_ANOVA)) else None
    return None if p is None else reliable(p, choices.confidence)


def _p_holm(pair: PairComparison, analysis: Analysis) -> float | None:
    if analysis.dataset.choices.primary == "ranks":
        return pair.ranks.p_holm
    return pair.logs.p_holm if pair.logs else None


def _steps(analysis: Analysis) -> str:
    """Return which neighbouring levels differed, as the end of a sentence; empty for one pair."""
    quantity, confidence = analysis.dataset.quantity, analysis.dataset.choices.confidence
    pairs = {
        (pair.from_level, pair.to_level): _p_holm(pair, analysis)
        for pair in analysis.inference.found(PAIRWISE) or ()
    }
    neighbours = [pairs.get(each) for each in pairwise(analysis.description["level"])]
    if len(neighbours) < 2 or None in neighbours:  # noqa: PLR2004
        return ""
    same = [
        f"{low:g} and {quantity.value(high)}"
        for (low, high), p in zip(pairwise(analysis.description["level"]), neighbours, strict=True)
        if p is not None and not reliable(p, confidence)
    ]
    if not same:
        return f"; each {quantity.level} {DIFFERED.past} from the next"
    if len(same) > MOST_LISTED:
        return f"; no difference was shown for {len(same)} of {len(neighbours)} steps"
    return "; no difference was shown between " + ", or between ".join(same)
