"""Write sentences on matching."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import (
    bracketed,
    counted,
    level_of,
    number,
    p_value,
    reliable,
)

if TYPE_CHECKING:
    from slipscale.analysis.tasks.matching.statistics import MatchedReference


def matching_answer(found: MatchedReference, confidence: float) -> str:
    """Return the sentence on one reference."""
    what = (
        f"{found.reference_um_pp:g} µm (peak to peak) was matched by {number(found.mean_um_pp, 3)} "
        f"µm ({counted(found.matches, 'match', 'matches')} of "
        f"{counted(found.participants, 'participant', 'participants')})"
    )
    bias = found.bias_um_pp
    if isinstance(bias, NotComputed):
        return f"{what}; bias not tested: {bias.reason}."
    verb = "differed from" if reliable(bias.p, confidence) else "did not differ reliably from"
    return (
        f"{what}, which {verb} it by {number(bias.mean, 3)} µm, {level_of(confidence)} CI "
        f"{bracketed(bias.interval, lambda value: number(value, 3))}, t({bias.df}) = "
        f"{number(bias.t)}, {p_value(bias.p)}."
    )


def matching_sentences(found: tuple[MatchedReference, ...], confidence: float) -> list[str]:
    """Return one sentence per reference."""
    return [matching_answer(each, confidence) + _besides(each) for each in found]


def _besides(found: MatchedReference) -> str:
    """Return the results of catch trials and of repeated references, if there are any."""
    said = ""
    if found.felt_again:
        said += f" The reference was felt again {number(found.felt_again)} times a match."
    if found.catch_error_um_pp is not None:
        trials = counted(found.catch_trials, "catch trial", "catch trials")
        said += (
            f" In {trials}, which began at the reference itself, the plate was left "
            f"{number(found.catch_error_um_pp, 3)} µm from it in the mean."
        )
    return said
