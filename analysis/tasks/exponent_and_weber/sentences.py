"""Write the sentences on the agreement of exponent and Weber fraction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.exponent_and_weber.statistics import EKMAN, PUBLISHED
from slipscale.analysis.writing.numbers import bracketed, counted, level_of, unit_number

if TYPE_CHECKING:
    from slipscale.analysis.statistics.psychometrics.psychometric_function import Estimate
    from slipscale.analysis.tasks.exponent_and_weber.statistics import ExponentAndWeber
    from slipscale.stimuli.quantity import Quantity

#: Text of each verdict, after "The exponent".
VERDICTS = {
    "agrees": "agrees with the Weber fraction",
    "does not agree": "does not agree with the Weber fraction",
    "undecided": "neither differs reliably from the Weber fraction's prediction nor is shown to "
    "equal it: the interval is too wide",
}


def sentences(
    found: tuple[ExponentAndWeber, ...], confidence: float, quantity: Quantity
) -> list[str]:
    """Return one paragraph per task."""
    return [sentence(one, confidence, quantity) for one in found]


def sentence(one: ExponentAndWeber, confidence: float, quantity: Quantity) -> str:
    """Return the measured and expected values, and whether they agree."""
    level = level_of(confidence)
    low, high = PUBLISHED
    people = counted(len(one.participants), "participant has", "participants have")
    weber = f"{unit_number(one.weber_fraction.value, 3)}, CI {_bracketed(one.weber_fraction)}"
    expected = one.expected_exponent
    text = (
        f"{people} both: exponent {one.exponent.value:.2f}, {level} CI "
        f"{bracketed(one.exponent.interval)}; Weber fraction at "
        f"{quantity.value(one.standard_um_pp)} ({one.task}) {weber}. By Ekman's law with "
        f"{unit_number(EKMAN, 2)} (Teghtsoonian, 1971) that Weber fraction goes with an "
        f"exponent of {expected.value:.2f}, CI "
        f"{bracketed(expected.interval)}. Here a just noticeable difference is "
        f"{unit_number(one.ekman_fraction.value, 3)} of the sensation, CI "
        f"{_bracketed(one.ekman_fraction)} (published: {unit_number(low, 3)} to "
        f"{unit_number(high, 3)}). The exponent {VERDICTS[one.verdict]}."
    )
    if one.grows:
        return text
    return (
        f"{text} Its interval contains 0, so an increase of sensation with the "
        f"{quantity.level} is not shown."
    )


def _bracketed(found: Estimate) -> str:
    return bracketed(found.interval, lambda value: unit_number(value, 3))
