"""Plot magnitude estimates against predicted friction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from slipscale.figure_style import BLUE, GREY, INK, ORANGE, canvas, styled
from slipscale.stimuli.film.shared_load import NOT_VALIDATED, band
from slipscale.stimuli.surface import VirtualSurface

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def perception_figure(
    amplitudes_um_pp: Sequence[float],
    means: Sequence[float],
    standard_deviations: Sequence[float] | None = None,
    *,
    roughness_um: float = 0.6,
    frequency_hz: float = 30_500.0,
    normal_force_n: float = 0.5,
) -> Figure:
    """Return a figure of slipperiness estimates against predicted relative friction.

    The figure shows both film models. A band shows the model in which asperities and film share the
    load.

    Parameters
    ----------
    amplitudes_um_pp : sequence of float
        Amplitudes of the surfaces, µm peak to peak.
    means : sequence of float
        Mean magnitude estimates, one per surface.
    standard_deviations : sequence of float, optional
        Standard deviations across participants.
    roughness_um, frequency_hz, normal_force_n : float
        See `VirtualSurface.predicted_relative_friction`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure, axes = canvas()
    models = (
        ("reynolds", "Reynolds equation (3)", ORANGE, "s"),
        ("closed form", "closed form (13)", BLUE, "o"),
    )
    surfaces = [VirtualSurface(level=a) for a in amplitudes_um_pp]
    for model, name, colour, marker in models:
        friction = [
            surface.predicted_relative_friction(
                roughness_um=roughness_um,
                frequency_hz=frequency_hz,
                normal_force_n=normal_force_n,
                model="reynolds" if model == "reynolds" else "closed form",
            )
            for surface in surfaces
        ]
        axes.errorbar(
            friction,
            means,
            yerr=standard_deviations,
            color=colour,
            marker=marker,
            capsize=3,
            elinewidth=1,
            label=name,
        )
    bands = [
        band(surface.amplitude_um_peak, frequency_hz=frequency_hz, normal_force_n=normal_force_n)
        for surface in surfaces
    ]
    least, most = zip(*bands, strict=True)
    axes.fill_betweenx(means, least, most, color=GREY, alpha=0.25, linewidth=0, label=NOT_VALIDATED)
    for amplitude, x, y in zip(amplitudes_um_pp, friction, means, strict=True):
        axes.annotate(
            f"{amplitude:g} µm",
            (x, y),
            xytext=(8, -13),
            textcoords="offset points",
            ha="left",
            color=INK,
            fontsize=9,
        )
    axes.invert_xaxis()
    axes.set(
        xlabel="Predicted relative friction µ'/µ (more slippery to the right)",
        ylabel="Magnitude estimate of slipperiness",
        ylim=(0, 105),
        title="Perception against predicted friction",
    )
    axes.legend(loc="center right", title=f"h_r = {roughness_um:g} µm, {normal_force_n:g} N")
    if standard_deviations is not None:
        axes.text(
            0.99,
            0.02,
            "bars: ± 1 standard deviation across participants",
            transform=axes.transAxes,
            ha="right",
            color=GREY,
            fontsize=8,
        )
    return figure
