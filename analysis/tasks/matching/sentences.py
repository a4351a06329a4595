"""Write sentences on matching."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    level_of,
    measured,
    number,
    p_value,
    reliable,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.matching.statistics import MatchedReference
    from slipscale.stimuli.quantity import Quantity


def matching_answer(found: MatchedReference, confidence: float, quantity: Quantity) -> str:
    """Return the sentence on one reference."""
    written = measured(quantity)
    what = (
        f"{quantity.with_convention(f'{found.reference_um_pp:g}')} was matched by "
        f"{quantity.value(written(found.mean_um_pp))} "
        f"({counted(found.matches, 'match', 'matches')} of "
        f"{counted(found.participants, 'participant', 'participants')})"
    )
    bias = found.bias_um_pp
    if isinstance(bias, NotComputed):
        return f"{what}; bias not tested: {bias.reason}."
    called = "a bias of" if reliable(bias.p, confidence) else "no reliable bias,"
    return (
        f"{what}: {called} {quantity.value(written(bias.mean))}, {level_of(confidence)} "
        f"CI {bracketed(bias.interval, written)}, t({bias.df}) = "
        f"{number(bias.t)}, {p_value(bias.p)}."
    )


def matching_sentences(
    found: tuple[MatchedReference, ...], confidence: float, quantity: Quantity
) -> list[str]:
    """Return one sentence per reference."""
    return [matching_answer(each, confidence, quantity) for each in found]
