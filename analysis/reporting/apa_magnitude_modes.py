"""The sentences on ratings on a line, ratio judgements and magnitude production."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING

from slipscale.analysis.reporting.apa import level_of, reliable
from slipscale.analysis.reporting.numbers import (
    bracketed,
    counted,
    number,
    p_value,
    significant,
    unit_number,
)
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from slipscale.analysis.statistics.productions import BothExponents, TaskProductions
    from slipscale.analysis.statistics.ratings import TaskRatings
    from slipscale.analysis.statistics.ratio_judgements import TaskRatios


def rating_title(found: TaskRatings) -> str:
    """Return what a task is called in the report."""
    return f"Visual analogue scale ({found.task})"


def rating_answer(found: TaskRatings) -> str:
    """Return the chief sentence on ratings."""
    means = ", ".join(
        f"{number(each.mean, 1)} ({_surface(each.surface)})" for each in found.surfaces
    )
    return (
        f"{rating_title(found)}, {counted(found.answers, 'rating', 'ratings')} of "
        f"{counted(found.participants, 'participant', 'participants')}: mean places on the line "
        f"from 0 (left) to 100 were {means}."
    )


def rating_tests(found: TaskRatings, confidence: float) -> str:
    """Return what was tested of ratings, and what they cannot say."""
    texts = []
    friedman, trend = found.friedman, found.page_trend
    if isinstance(friedman, NotComputed):
        texts.append(f"Whether ratings differ between surfaces was not tested: {friedman.reason}.")
    else:
        verb = "differed" if reliable(friedman.p, confidence) else "did not differ reliably"
        texts.append(
            f"Ratings {verb} between surfaces (Friedman's test on ranks, χ²({friedman.df}, "
            f"n = {friedman.n}) = {number(friedman.chi2)}, {p_value(friedman.p)}, Kendall's W = "
            f"{unit_number(friedman.kendalls_w)})."
        )
    if not isinstance(trend, NotComputed):
        verb = "grew" if reliable(trend.p, confidence) else "did not grow reliably"
        texts.append(
            f"They {verb} with amplitude (Page's L = {trend.L:g}, {p_value(trend.p)}, one-sided, "
            f"n = {trend.n})."
        )
    return " ".join([*texts, *rating_biases(found, confidence)])


def rating_biases(found: TaskRatings, confidence: float) -> list[str]:
    """Return the sentences on what draws ratings: the start, the ends of the line, lapses."""
    texts = []
    start = found.start_effect
    if isinstance(start, NotComputed):
        texts.append(f"The pull of the mark's start was not measured: {start.reason}.")
    else:
        low, high = start.interval
        told = "not reliably " if low <= 0 <= high else ""
        texts.append(
            f"A mark that started 10 places further to the right was {told}put further to the "
            f"{'right' if start.mean >= 0 else 'left'}: by {number(10 * abs(start.mean))} places, "
            f"{level_of(confidence)} CI of the shift to the right [{number(10 * low)}, "
            f"{number(10 * high)}]."
        )
    ends = sum(each.at_left + each.at_right for each in found.surfaces)
    if ends:
        texts.append(
            f"{ends} of {found.answers} ratings are at an end of the line, where means are held "
            "back."
        )
    if found.catch_mean is not None:
        texts.append(
            f"The bare plate of {counted(found.catch_trials, 'catch trial', 'catch trials')} was "
            f"rated {number(found.catch_mean, 1)}."
        )
    texts.append(
        "The line is bounded and has no unit: its places are compared and averaged, and allow "
        "neither ratios nor an exponent."
    )
    return texts


def rating_sentences(found: tuple[TaskRatings, ...] | NotComputed, confidence: float) -> list[str]:
    """Return a paragraph a task of ratings."""
    if isinstance(found, NotComputed):
        return []
    return [f"{rating_answer(task)} {rating_tests(task, confidence)}" for task in found]


def ratio_title(found: TaskRatios) -> str:
    """Return what a task is called in the report."""
    return f"Ratio judgements against {found.standard_um_pp:g} µm ({found.task})"


def ratio_answer(found: TaskRatios, confidence: float) -> str:
    """Return the chief sentence on ratio judgements."""
    what = (
        f"{ratio_title(found)}, {counted(found.answers, 'judgement', 'judgements')} of "
        f"{counted(found.participants, 'participant', 'participants')}"
    )
    law = found.power_law
    if isinstance(law, NotComputed):
        return f"{what}: no exponent ({law.reason})."
    return (
        f"{what}: the exponents of participants' power functions of amplitude averaged "
        f"{number(law.exponent)}, {level_of(confidence)} CI {bracketed(law.interval)} "
        f"(n = {law.n}; {law.points} amplitudes above 0 µm)."
    )


def ratio_sentences(found: tuple[TaskRatios, ...] | NotComputed, confidence: float) -> list[str]:
    """Return a paragraph a task of ratio judgements."""
    if isinstance(found, NotComputed):
        return []
    return [f"{ratio_answer(task, confidence)} {_ratios(task, confidence)}" for task in found]


def _ratios(found: TaskRatios, confidence: float) -> str:
    each = "; ".join(
        f"{one.comparison_um_pp:g} µm {significant(one.ratio)} times"
        + ("" if one.interval is None else f", {bracketed(one.interval, significant)}")
        for one in found.surfaces
    )
    text = (
        f"As slippery as the standard (geometric means, {level_of(confidence)} CI of participants' "
        f"mean logarithms): {each}."
    )
    if found.catch_ratio is None:
        return text
    return (
        f"{text} Against itself the standard was judged {significant(found.catch_ratio)} times as "
        f"slippery ({counted(found.catch_trials, 'catch trial', 'catch trials')}; right: 1)."
    )


def production_title(found: TaskProductions) -> str:
    """Return what a task is called in the report."""
    return f"Magnitude production ({found.task})"


def production_answer(found: TaskProductions, confidence: float) -> str:
    """Return the chief sentence on production."""
    what = (
        f"{production_title(found)}, {counted(found.answers, 'production', 'productions')} of "
        f"{counted(found.participants, 'participant', 'participants')}, with a standard of "
        f"{found.standard_um_pp:g} µm called {found.modulus:g}"
    )
    slope = found.slope
    if isinstance(slope, NotComputed):
        return f"{what}: no exponent ({slope.reason})."
    grew = (
        f"{what}: log amplitude grew by {number(slope.mean)} per log number (mean of participants' "
        f"slopes), {level_of(confidence)} CI {bracketed(slope.interval)}"
    )
    if found.exponent is None:
        return f"{grew}; a slope that is not above 0 has no exponent."
    if found.exponent_interval is None:
        return (
            f"{grew}: an exponent of {number(found.exponent)}, whose interval has no upper bound."
        )
    return (
        f"{grew}: an exponent of {number(found.exponent)}, CI {bracketed(found.exponent_interval)}."
    )


def both_answer(found: BothExponents, confidence: float) -> str:
    """Return the sentence on production beside estimation."""
    low, high = found.ratio_interval
    differs = (
        "which does not tell them apart"
        if low <= 1 <= high
        else "as people who shorten the range of what they control do"
        if found.ratio > 1
        else "the other way round than people who shorten the range of what they control"
    )
    return (
        f"Of the {found.n} who did both, the exponent of production was "
        f"{number(found.production)} and that of {found.counterpart} {number(found.estimation)} "
        f"(geometric means): {number(found.ratio)} times as large, {level_of(confidence)} CI "
        f"{bracketed(found.ratio_interval)}, {differs}. Their geometric mean, the usual remedy "
        f"(Stevens & Greenbaum, 1966), is {number(found.combined)}, CI "
        f"{bracketed(found.combined_interval)}."
    )


def production_answers(found: TaskProductions, confidence: float) -> list[str]:
    """Return the chief sentences on a task of production."""
    texts = [production_answer(found, confidence)]
    if not isinstance(found.both, NotComputed):
        texts.append(both_answer(found.both, confidence))
    return texts


def production_sentences(
    found: tuple[TaskProductions, ...] | NotComputed, confidence: float
) -> list[str]:
    """Return a paragraph a task of production."""
    if isinstance(found, NotComputed):
        return []
    return [
        " ".join([*production_answers(task, confidence), *production_biases(task, confidence)])
        for task in found
    ]


def production_biases(found: TaskProductions, confidence: float) -> list[str]:
    """Return the sentences on what draws productions: the beginning, the bounds, lapses."""
    texts = []
    beginning = found.beginning
    if not isinstance(beginning, NotComputed):
        percent = 100 * (exp(beginning.mean) - 1)
        low, high = (100 * (exp(bound) - 1) for bound in beginning.interval)
        texts.append(
            f"From a high beginning the plate was left {number(abs(percent), 1)} % "
            f"{'higher' if percent >= 0 else 'lower'} than from a low one, {level_of(confidence)} "
            f"CI of the rise [{number(low, 1)}, {number(high, 1)}] %."
        )
    if found.at_bounds:
        texts.append(
            f"{found.at_bounds} of {found.answers} productions ended within a notch of how far the "
            "plate can be turned. Those who meant to go beyond make the slope too small and the "
            "exponent too large."
        )
    if found.catch_um_pp is not None:
        texts.append(
            f"The standard's own number was produced as {significant(found.catch_um_pp)} µm "
            f"({counted(found.catch_trials, 'catch trial', 'catch trials')}; the standard: "
            f"{found.standard_um_pp:g} µm)."
        )
    return texts


def _surface(name: str) -> str:
    """Return a surface as sentences name it: an amplitude with its unit, or a texture's name."""
    try:
        return f"{float(name):g} µm"
    except ValueError:
        return name
