"""Write the report section on the growth of sensation."""

from __future__ import annotations

from collections.abc import Mapping

from markupsafe import Markup

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.analysis.tasks.estimation.growth.growth_models import GrowthComparison
from slipscale.analysis.tasks.estimation.growth.statistics import FrictionGrowth
from slipscale.analysis.tasks.estimation.statistics import GROWTH
from slipscale.analysis.tasks.kind import Analysis
from slipscale.analysis.writing import html
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import grouped, joined
from slipscale.stimuli.quantity import Quantity


def growth(analysis: Analysis, svgs: Mapping[str, str]) -> ReportSection:
    """Return the section with growth functions and exponents."""
    section = ReportSection("Growth of sensation")
    if "growth" not in svgs:
        return section
    found, quantity = analysis.inference[GROWTH], analysis.dataset.quantity
    section.blocks.append(
        html.figure(
            svgs["growth"],
            f"Top: {'growth functions for all participants together' if found else 'means'}. "
            "Bottom: power function on logarithmic axes, excluding "
            f"{quantity.value(0)}; the slope is the exponent. Error bars: t-based intervals across "
            "participants.",
            f"Two charts of geometric means against {quantity.name}: with fitted growth functions, "
            "and on logarithmic axes with the power function",
        )
    )
    if isinstance(found, NotComputed):
        section.blocks.append(
            html.paragraph(f"Growth functions were not compared: {found.reason}.", "note")
        )
        return section
    section.gist = [apa.growth(found, analysis.dataset.choices.confidence, quantity)]
    section.blocks.append(_models(found.of_level, quantity))
    if isinstance(found.friction, FrictionGrowth):
        section.blocks.append(html.paragraph(_of_friction(found.friction)))
        bands = [
            f"{found.friction.reduction[amplitude]:.2f} [{least:.2f} to {most:.2f}] at "
            f"{quantity.value(amplitude)}"
            for amplitude, (least, most) in found.friction.shared_load.items()
            if amplitude
        ]
        section.blocks.append(
            html.paragraph(
                f"Predicted fractional decrease in friction: {joined(bands)}. The first number "
                "applies if the film acts alone; the range in brackets applies if skin asperities "
                "and the film share the load (not validated).",
                "note",
            )
        )
    if "exponents" in svgs:
        section.blocks.append(_exponents(analysis, svgs["exponents"]))
    own = found.individual
    if own:
        best = ", ".join(
            f"{apa.MODEL_NAMES[name]} ({count})" for name, count in own.best.items() if count
        )
        section.blocks.append(
            html.paragraph(
                "No single participant's trials discriminate between growth functions."
                if own.undecided == len(own.participants)
                else f"Functions that fit individual participants best: {best or 'none'}; "
                f"undecided (too few trials, or ΔAICc below 2): {own.undecided}.",
                "note",
            )
        )
    return section


def _exponents(analysis: Analysis, svg: str) -> Markup:
    level = f"{100 * analysis.dataset.choices.confidence:g} %"
    return html.figure(
        svg,
        "Individual exponents before and after shrinkage. Rings: least-squares fits to each "
        f"participant's trials. Dots: estimates from the hierarchical Bayesian model, with {level} "
        "credible intervals. Line and band: the group.",
        "Chart of individual exponents, before and after shrinkage towards the group",
    )


def _of_friction(found: FrictionGrowth) -> str:
    """Return a sentence on the best growth function of the predicted reduction in friction."""
    compared = found.comparison
    weight = grouped(compared.models[compared.best].weight)
    verb = "is not clearly better than the next function" if compared.undecided else "fits best"
    return (
        "When estimates are related to the predicted reduction in friction, 1 − µ′/µ "
        "(Reynolds equation, h_r 0.6 µm, 30.5 kHz, 0.5 N), "
        f"{apa.MODEL_NAMES[compared.best]} {verb} (weight {weight}; all models are in "
        "inference.json)."
    )


def _models(found: GrowthComparison, quantity: Quantity) -> Markup:
    rows, unit = [], f" {quantity.unit}".rstrip()
    for name, model in found.models.items():
        parameters = ", ".join(
            f"{key} not determined".replace("_", " ")
            if key in model.fit.at_bound
            else f"{key} {value:.3g}".replace("-", "−").replace("_", " ")
            + ("" if key == "exponent" else unit)
            for key, value in model.fit.parameters.items()
        )
        rows.append(
            [
                apa.MODEL_NAMES[name][0].upper() + apa.MODEL_NAMES[name][1:],
                parameters,
                grouped(model.fit.sd, 3),
                grouped(model.delta_aicc, 2),
                grouped(model.weight, 2),
            ]
        )
    return html.table(
        html.columns("Model", "Parameters", ("Residual SD", "log"), "ΔAICc", "Weight", left=2),
        rows,
        f"{quantity.headed(f'Growth functions against {quantity.name}')}, fitted to {found.n} "
        "participants' mean log estimates."
        + (
            " No function is highlighted because the two lowest AICc values differ by less than 2."
            if found.undecided
            else ""
        ),
        marked=None if found.undecided else list(found.models).index(found.best),
    )
