"""The sentences on paired comparison, triads and matching."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.reporting.apa import level_of, reliable
from slipscale.analysis.reporting.numbers import bracketed, counted, number, p_value
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    from slipscale.analysis.statistics.matching import MatchedReference
    from slipscale.analysis.statistics.scaling.task_scales import TaskScale


def title(found: TaskScale) -> str:
    """Return what a task is called in the report."""
    form = "Paired comparison" if found.consistency else "Triads"
    return f"{form} of {len(found.surfaces)} surfaces ({found.task})"


def fit(found: TaskScale) -> str:
    """Return how well one scale describes the answers: the table's caption."""
    texts = []
    for name, scale in (("Bradley-Terry", found.bradley_terry), ("Thurstone V", found.thurstone)):
        if isinstance(scale, NotComputed):
            if found.consistency:
                texts.append(f"{name}: not computed ({scale.reason}).")
        elif not isinstance(scale.fit, NotComputed):
            texts.append(
                f"{name}: deviance {number(scale.fit.deviance)} with {scale.fit.df} degrees of "
                f"freedom, {p_value(scale.fit.p)}, answers taken as independent."
            )
    if not isinstance(found.transitivity, NotComputed):
        counts = found.transitivity
        texts.append(
            f"Of {counts.triads} triads of surfaces {counts.weak_violations} break weak, "
            f"{counts.moderate_violations} moderate and {counts.strong_violations} strong "
            "stochastic transitivity."
        )
    if not isinstance(found.differences, NotComputed):
        texts.append(
            f"Maximum likelihood difference scaling of {found.differences.answers} answers; noise "
            f"{number(found.differences.noise)} of the whole scale, CI "
            f"{bracketed(found.differences.noise_interval)}."
        )
    return " ".join(texts)


def scale_answer(found: TaskScale) -> str:
    """Return the chief sentence of a task of comparisons."""
    scale = found.bradley_terry if found.consistency else found.differences
    what = f"{title(found)}, {counted(found.answers, 'answer', 'answers')} of " + counted(
        found.participants, "participant", "participants"
    )
    if isinstance(scale, NotComputed):
        counts = zip(found.surfaces, found.chosen, found.compared, strict=False)
        shares = ", ".join(f"{name}: {chosen} of {there}" for name, chosen, there in counts)
        told = f"; chosen: {shares}" if shares else ""
        return f"{what}: no scale ({scale.reason}){told}."
    order = sorted(range(len(found.surfaces)), key=lambda place: scale.values[place])
    names = ", ".join(f"{found.surfaces[place]} ({number(scale.values[place])})" for place in order)
    return f"{what}: from the least to the most slippery, with scale values: {names}."


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


def scale_sentences(found: tuple[TaskScale, ...] | NotComputed) -> list[str]:
    """Return a paragraph a task of comparisons."""
    if isinstance(found, NotComputed):
        return []
    return [f"{scale_answer(task)} {fit(task)}".strip() for task in found]


def matching_sentences(
    found: tuple[MatchedReference, ...] | NotComputed, confidence: float
) -> list[str]:
    """Return a sentence a reference."""
    if isinstance(found, NotComputed):
        return []
    return [matching_answer(each, confidence) + _besides(each) for each in found]


def _besides(found: MatchedReference) -> str:
    """Return what catch trials and the reference felt again say, where there are any."""
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
