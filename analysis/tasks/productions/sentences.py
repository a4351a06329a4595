"""Write sentences on magnitude production."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    level_of,
    number,
    significant,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.productions.statistics import BothExponents, TaskProductions
    from slipscale.stimuli.quantity import Quantity


def production_title(found: TaskProductions) -> str:
    """Return the name of a task in the report."""
    return f"Magnitude production ({found.task})"


def production_answer(found: TaskProductions, confidence: float, quantity: Quantity) -> str:
    """Return the main sentence on production."""
    what = (
        f"{production_title(found)}, {counted(found.answers, 'production', 'productions')} of "
        f"{counted(found.participants, 'participant', 'participants')}, with a standard of "
        f"{quantity.value(found.standard_um_pp)} called {found.modulus:g}"
    )
    slope = found.slope
    if isinstance(slope, NotComputed):
        return f"{what}: no exponent ({slope.reason})."
    grew = (
        f"{what}: log {quantity.level} grew by {number(slope.mean)} per log number (mean of "
        f"participants' slopes), {level_of(confidence)} CI {bracketed(slope.interval)}"
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
    """Return the sentence that compares production with estimation."""
    low, high = found.ratio_interval
    differs = (
        "which is not a reliable difference"
        if low <= 1 <= high
        else "consistent with the regression bias in magnitude production"
        if found.ratio > 1
        else "opposite to the regression bias in magnitude production"
    )
    return (
        f"Of the {found.n} who did both, the exponent of production was "
        f"{number(found.production)} and that of {found.counterpart} {number(found.estimation)} "
        f"(geometric means): {number(found.ratio)} times as large, {level_of(confidence)} CI "
        f"{bracketed(found.ratio_interval)}, {differs}. Their geometric mean, the usual remedy "
        f"(Stevens & Greenbaum, 1966), is {number(found.combined)}, CI "
        f"{bracketed(found.combined_interval)}."
    )


def production_answers(found: TaskProductions, confidence: float, quantity: Quantity) -> list[str]:
    """Return the main sentences on a production task."""
    texts = [production_answer(found, confidence, quantity)]
    if found.both:
        texts.append(both_answer(found.both, confidence))
    return texts


def production_sentences(
    found: tuple[TaskProductions, ...], confidence: float, quantity: Quantity
) -> list[str]:
    """Return one paragraph per production task."""
    return [
        " ".join(
            [
                *production_answers(task, confidence, quantity),
                *production_biases(task, confidence, quantity),
            ]
        )
        for task in found
    ]


def production_biases(found: TaskProductions, confidence: float, quantity: Quantity) -> list[str]:
    """Return the sentences on what draws productions: the beginning, the bounds, lapses."""
    texts = []
    beginning = found.beginning
    if beginning:
        percent = 100 * (exp(beginning.mean) - 1)
        low, high = (100 * (exp(bound) - 1) for bound in beginning.interval)
        texts.append(
            f"From a high start the plate was set {number(abs(percent), 1)} % "
            f"{'higher' if percent >= 0 else 'lower'} than from a low one, "
            f"{level_of(confidence)} CI of the rise [{number(low, 1)}, {number(high, 1)}] %."
        )
    if found.at_bounds:
        texts.append(
            f"{found.at_bounds} of {found.answers} productions ended within a notch of the "
            "limits of the adjustment. If people wanted to go further, the slope is too small "
            "and the exponent too large."
        )
    if found.catch_um_pp is not None:
        texts.append(
            "The standard's own number was produced as "
            f"{quantity.value(significant(found.catch_um_pp))} "
            f"({counted(found.catch_trials, 'catch trial', 'catch trials')}; the standard: "
            f"{quantity.value(found.standard_um_pp)})."
        )
    return texts
