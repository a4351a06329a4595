"""Write sentences on scales from paired comparison and triads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.writing.numbers import bracketed, counted, number, p_value

if TYPE_CHECKING:
    from slipscale.analysis.tasks.scales.statistics import TaskScale
    from slipscale.stimuli.quantity import Quantity


def title(found: TaskScale) -> str:
    """Return the name of a task in the report."""
    form = "Paired comparison" if found.consistency else "Triads"
    return f"{form} of {len(found.surfaces)} surfaces ({found.task})"


def fit(found: TaskScale) -> str:
    """Return the goodness of fit of one scale, for the table's caption."""
    texts, fitted = [], []
    for name, scale in (("Bradley-Terry", found.bradley_terry), ("Thurstone V", found.thurstone)):
        if isinstance(scale, NotComputed):
            if found.consistency:
                texts.append(f"{name}: not computed ({scale.reason}).")
        elif scale.fit:
            fitted.append(
                f"{name}, deviance {number(scale.fit.deviance)} (df = {scale.fit.df}, "
                f"{p_value(scale.fit.p)})"
            )
    if fitted:
        texts.append(
            f"Fit with Firth's correction, treating answers as independent: {'; '.join(fitted)}."
        )
    if found.transitivity:
        counts = found.transitivity
        texts.append(
            f"Violations of weak, moderate and strong stochastic transitivity in {counts.triads} "
            f"triads: {counts.weak_violations}, {counts.moderate_violations}, "
            f"{counts.strong_violations}."
        )
    if found.differences:
        texts.append(
            f"Maximum likelihood difference scaling; noise {number(found.differences.noise)} of "
            "the whole scale, CI "
            f"{bracketed(found.differences.noise_interval)}."
        )
    return " ".join(texts)


def scale_answer(found: TaskScale, quantity: Quantity) -> str:
    """Return the main sentence of a comparison task."""
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
    return f"{what}: scale values, from the least to the most {quantity.adjective}: {names}."
