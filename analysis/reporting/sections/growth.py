"""The growth of sensation: its figure and the models compared."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from analysis.reporting import html
from analysis.reporting.apa import MODEL_NAMES
from analysis.reporting.html import Column, Section, number

if TYPE_CHECKING:
    from collections.abc import Mapping

    from analysis.result import Analysis


def growth(analysis: Analysis, svgs: Mapping[str, str]) -> Section:
    """Return the growth of sensation: figure and models."""
    section = Section("Growth of sensation")
    if "growth" not in svgs:
        return section
    found = analysis.inference["growth"]
    section.blocks.append(
        html.figure(
            svgs["growth"],
            "Left: growth functions fitted to all participants at once, each participant with an "
            "own factor. Right: the same geometric means on logarithmic axes; the slope is the "
            "exponent. Bars: Student's intervals over participants. 0 µm has no place on a "
            "logarithmic axis and takes no part.",
            "Two charts of geometric means against amplitude: with fitted growth functions, and on "
            "logarithmic axes with the power function",
        )
    )
    if "reason" in found:
        section.blocks.append(html.paragraph(f"Growth functions: {found['reason']}.", "note"))
        return section
    against = [("amplitude", "Against amplitude (µm, peak to peak)")]
    if "reason" not in found["friction"]:
        against.append(
            (
                "friction",
                (
                    "Against the reduction of friction that the film predicts, 1 − µ′/µ (Reynolds' "
                    "equation, h_r 0.6 µm, 30.5 kHz, 0.5 N)"
                ),
            )
        )
    section.blocks += [
        _models(found[key], title, " µm" if key == "amplitude" else "") for key, title in against
    ]
    if "reason" not in found["individual"]:
        best = ", ".join(
            f"{MODEL_NAMES[name]} {count}" for name, count in found["individual"]["best"].items()
        )
        everybody = sum(found["individual"]["best"].values()) + found["individual"]["undecided"]
        section.blocks.append(
            html.paragraph(
                "Too few trials to compare growth functions in single participants; their "
                "exponents are descriptive."
                if found["individual"]["undecided"] == everybody
                else f"Favoured in single participants' trials: {best}; undecided for lack of "
                f"trials {found['individual']['undecided']}. With so few amplitudes a "
                "participant's exponent is descriptive.",
                "note",
            )
        )
    return section


def _models(found: Mapping[str, Any], title: str, unit: str) -> Any:
    rows = []
    for name, model in found["models"].items():
        title_ = MODEL_NAMES[name]
        parameters = ", ".join(
            f"{key} {value:.3g}".replace("-", "−") + ("" if key == "exponent" else unit)
            for key, value in model["parameters"].items()
        )
        rows.append(
            [
                title_[0].upper() + title_[1:],
                parameters,
                number(model["sd"], 3),
                number(model["log_likelihood"], 2),
                number(model["delta_aicc"], 2),
                number(model["weight"], 2),
                number(model["bic"], 1),
            ]
        )
    return html.table(
        [
            Column(title="Model", left=True),
            Column(title="Parameters", left=True),
            Column(title="Residual SD", unit="log"),
            Column(title="Log-likelihood"),
            Column(title="ΔAICc"),
            Column(title="Weight"),
            Column(title="BIC"),
        ],
        rows,
        f"{title}: growth functions of {found['n']} participants' mean log estimates, compared by "
        "the corrected Akaike criterion.",
        marked=list(found["models"]).index(found["best"]),
    )
