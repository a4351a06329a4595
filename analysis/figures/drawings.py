"""Draw the paper's Figs. 1, 2, 6, 7, 10, 13 and 14 from the models, to scale unless stated.

Fig. 13 is the measured mode as the finite-element model predicts it. Fig. 14 shows the bench as the
parts of Slipscale.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.figure_style import BLUE, GREY, INK, PALE, VERMILION, canvas, note, styled
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.bending import Bending
from slipscale.hardware.plate.geometry import DEFAULT, Layout
from slipscale.stimuli.film.squeeze_film import FINGER
from slipscale.stimuli.quantities import MILLI

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from slipscale.stimuli.quantities import Array

#: Fill colours of the resonator and of ceramics with polarity +1 and -1.
METAL, PLUS, MINUS = "#E8C39E", "#9CC3DE", "#D7E7F2"
#: Parts of the bench: centre, name, part of Slipscale.
BENCH = (
    ((0.13, 0.78), "participant,\nclosed headphones", "screen, questions, masking noise"),
    ((0.5, 0.78), "box with a rectangular\nopening", "contact: position and force"),
    ((0.87, 0.78), "tactile plate", "plate file, calibration, limits"),
    ((0.13, 0.24), "experimenter", "study, session, journal"),
    (
        (0.87, 0.24),
        "voltage source at the\nresonance frequency",
        "plate driver and backend, readback",
    ),
)
#: Pairs of parts, as indices of `BENCH`, that act on each other.
LINKS = ((0, 1), (1, 2), (3, 4), (4, 2), (3, 0))


def _box(axes: Axes, corner: tuple[float, float], size: tuple[float, float], colour: str) -> None:
    (x, y), (width, height) = corner, size
    axes.fill(
        [x, x + width, x + width, x],
        [y, y, y + height, y + height],
        facecolor=colour,
        edgecolor=INK,
        linewidth=0.6,
    )


@styled
def plate_figure() -> Figure:
    """Return Fig. 1: the ceramics from below with their polarity, and the plate from the side."""
    layout = Layout.prototype()
    figure, (below, side) = canvas(
        2, 1, (6.6, 5.4), sharex=True, gridspec_kw={"height_ratios": (6, 1)}
    )
    x0, y0 = -layout.length_mm / 2, -layout.width_mm / 2
    _box(below, (x0, y0), (layout.length_mm, layout.width_mm), METAL)
    for patch in layout.patches:
        (left, _), (low, _) = patch.region.span_mm(0), patch.region.span_mm(1)
        colour = PLUS if patch.polarity > 0 else MINUS
        _box(below, (left, low), patch.region.size_mm, colour)
        below.text(
            *patch.region.at_mm, "+" if patch.polarity > 0 else "−", ha="center", va="center"
        )
    below.set(
        ylabel="y (mm)",
        aspect="equal",
        title=f"Ceramics from below: {layout.columns} × {layout.rows}, with their polarity",
    )
    hp, hi = layout.ceramic_thickness_mm, layout.resonator_thickness_mm
    _box(side, (x0, hp), (layout.length_mm, hi), METAL)
    for patch in layout.patches:
        _box(side, (patch.region.span_mm(0)[0], 0), (patch.region.size_mm[0], hp), PLUS)
    note(side, "touch surface", (-24, 7), (-20, hp + hi))
    side.set(xlabel="x (mm)", ylabel="z (mm)", aspect="equal", ylim=(-1, 9), title="Side, to scale")
    for axes in (below, side):
        axes.grid(visible=False)
    return figure


@styled
def profile_figure() -> Figure:
    """Return Fig. 2: the profile of a fingertip with epidermal ridges over the plate."""
    figure, axes = canvas(size=(6.6, 3.2))
    period, height = FINGER.ridge_period_um, 2 * FINGER.ridge_amplitude_um
    x = np.linspace(-1.5 * period, 1.5 * period, 400)
    skin = height / 2 * (1 + np.cos(2 * np.pi * x / period))
    axes.fill_between(x, skin, 190, color="#F2D6C4", linewidth=0)
    axes.plot(x, skin, color=VERMILION)
    axes.fill_between(x, -40, 0, color=METAL, linewidth=0)
    axes.text(0, 160, "finger", ha="center")
    axes.text(0, -26, "plate", ha="center")
    for start, end, text, at in (
        ((-period / 2, 112), (period / 2, 112), f"L = {period:g} µm", (0, 124)),
        ((period, 0), (period, height), f"2h_e = {height:g} µm", (period, 108)),
    ):
        axes.annotate("", xy=end, xytext=start, arrowprops={"arrowstyle": "<->", "color": INK})
        axes.text(*at, text, ha="center", color=INK)
    axes.set(
        xlabel="x (µm)",
        ylabel="z (µm)",
        aspect="equal",
        ylim=(-40, 190),
        title="Approximate profile of a fingertip, to scale",
    )
    axes.grid(visible=False)
    return figure


def _section(axes: Axes, bent: Bending, lift: float) -> None:
    """Draw the layers of a section, with its deflection times ``lift``."""
    section = bent.section
    x = np.linspace(0, bent.half_wave_mm, 101)
    raised = np.asarray(bent.deflection_um(x)) * MILLI * lift
    hp, hi = section.ceramic_thickness_mm, section.resonator_thickness_mm
    axes.fill_between(x, raised, raised + hp, facecolor=PLUS, edgecolor=INK, linewidth=0.6)
    axes.fill_between(
        x, raised + hp, raised + hp + hi, facecolor=METAL, edgecolor=INK, linewidth=0.6
    )
    axes.plot(x, raised + bent.neutral_mm, color=INK, linestyle="-.", linewidth=1)
    axes.plot([0, bent.half_wave_mm], [-0.25, -0.25], "^", color=GREY, markersize=9)
    axes.set(xlabel="x (mm)", ylabel="z (mm)", aspect="equal", xlim=(-1, bent.half_wave_mm + 5))
    axes.grid(visible=False)


@styled
def section_figure() -> Figure:
    """Return Fig. 6: the simply supported half-wavelength section, to scale."""
    figure, axes = canvas(size=(6.6, 2.6))
    section = BeamSection.printed()
    bent = Bending(section=section, half_wave_mm=83 / 8, voltage_v=0.0)
    _section(axes, bent, 0.0)
    right = bent.half_wave_mm + 0.4
    axes.text(right, 1.9, "resonator, h_i = 2 mm", va="center")
    axes.text(right, 0.4, "ceramic, h_p = 1 mm", va="center")
    axes.text(0.3, bent.neutral_mm + 0.12, f"z0 = {bent.neutral_mm:.2f} mm", fontsize=8.5)
    axes.set(ylim=(-0.9, 3.8), title="Half-wavelength section, λ/2 = 83 mm / 8, to scale")
    return figure


@styled
def bending_figure() -> Figure:
    """Return Fig. 7: the section bent by contracting ceramics; the deflection is enlarged."""
    figure, axes = canvas(size=(6.6, 3.0))
    bent = Bending(section=BeamSection.printed(), half_wave_mm=83 / 8, voltage_v=15.0)
    _section(axes, bent, 50_000.0)
    middle = float(bent.deflection_um(bent.half_wave_mm / 2))
    axes.annotate(
        "", xy=(1.4, 0.55), xytext=(3.4, 0.9), arrowprops={"arrowstyle": "<-", "color": BLUE}
    )
    axes.annotate(
        "", xy=(9.0, 0.55), xytext=(7.0, 0.9), arrowprops={"arrowstyle": "<-", "color": BLUE}
    )
    axes.text(
        bent.half_wave_mm + 0.4,
        1.6,
        f"15 V: {1e3 * middle:.0f} nm at λ/4\n1/ρ = {bent.curvature_per_m:.2g} per m",
    )
    axes.set(ylim=(-0.9, 5.4), title="Bent by contracting ceramics, deflection × 50 000")
    return figure


@styled
def mesh_figure() -> Figure:
    """Return Fig. 10: the elements of the finite-element model, of which a quarter is solved."""
    from slipscale.hardware.plate.finite_elements import assemble

    layout = Layout.prototype()
    parts = assemble(layout, DEFAULT)
    figure, (above, side) = canvas(
        2, 1, (6.6, 5.2), sharex=True, gridspec_kw={"height_ratios": (5, 1.3)}
    )
    # Every second coordinate is an edge of an element; the others are nodes in the middle of edges.
    x, y, z = (np.unique(np.round(each / MILLI, 6))[::2] for each in parts.nodes)
    hp, top = layout.ceramic_thickness_mm, float(z[-1])
    _box(above, (0, 0), (x[-1], y[-1]), METAL)
    _box(side, (0, hp), (x[-1], top - hp), METAL)
    for patch in layout.patches:
        (left, right), (low, high) = (np.maximum(patch.region.span_mm(axis), 0) for axis in (0, 1))
        if right == 0 or high == 0:
            continue
        _box(above, (left, low), (right - left, high - low), PLUS)
        if low == 0:
            _box(side, (left, 0), (right - left, hp), PLUS)
            side.vlines(x[(x > left) & (x < right)], 0, hp, color=INK, linewidth=0.4)
    above.vlines(x, 0, y[-1], color=INK, linewidth=0.4)
    above.hlines(y, 0, x[-1], color=INK, linewidth=0.4)
    side.vlines(x, hp, top, color=INK, linewidth=0.4)
    side.hlines(z[z >= hp], 0, x[-1], color=INK, linewidth=0.4)
    for axes in (above, side):
        axes.set_aspect("equal")
        axes.grid(visible=False)
    above.set(ylabel="y (mm)", title="Elements of the quarter that is solved; blue: over a ceramic")
    side.set(
        xlabel="x (mm)",
        ylabel="z (mm)",
        title="At y = 0: ceramics (blue) with gaps below, resonator above",
    )
    return figure


@styled
def measured_mode_figure() -> Figure:
    """Return Fig. 13: the mode along the plate's edge, as predicted, next to the measured one."""
    from slipscale.hardware.plate.paper_study import harmonic, prototype_modes
    from slipscale.hardware.plate.vibration import surface_response_um

    found = prototype_modes()
    peak = harmonic(found)
    nodes, amplitude = surface_response_um(found, peak.peak_hz, 15.0, 1 / 60)
    x, shape = _along_edge(found.parts.nodes[:, nodes] / MILLI, amplitude)
    figure, axes = canvas(size=(6.6, 4.0))
    axes.plot(
        x,
        shape,
        color=BLUE,
        label=f"finite elements at the edge: {peak.peak_hz / 1e3:.2f} kHz, "
        f"{peak.peak_um_pp:.2f} µm",
    )
    axes.axhline(0, color=PALE, linewidth=0.8)
    for sign in (-1, 1):
        axes.axhline(
            sign * 2.3 / 2,
            color=VERMILION,
            linestyle="--",
            linewidth=1.2,
            label="measured in the paper: 30.5 kHz, about 2.3 µm" if sign > 0 else None,
        )
    crossings = int(np.sum(np.diff(np.sign(shape)) != 0))
    axes.set(
        xlabel="Position along the plate (mm)",
        ylabel="Deflection at its largest (µm)",
        title=f"(8;0) mode at 15 V: {crossings} nodal lines, amplitudes peak to peak",
        xlim=(-41.5, 41.5),
    )
    figure.legend(loc="outside lower center", ncols=1)
    return figure


def _along_edge(nodes_mm: Array, amplitude: Array) -> tuple[Array, Array]:
    """Return x in mm along the whole edge, and the deflection in phase with its largest value."""
    edge = np.isclose(nodes_mm[1], nodes_mm[1].max())
    order = np.argsort(nodes_mm[0, edge])
    x, w = nodes_mm[0, edge][order], amplitude[edge][order]
    largest = w[np.argmax(np.abs(w))]
    shape = np.real(w * np.conj(largest)) / abs(largest)
    if x[0] >= 0:  # a quarter is solved, and the mode is even in x
        x, shape = np.concatenate([-x[:0:-1], x]), np.concatenate([shape[:0:-1], shape])
    return x, shape


@styled
def bench_figure() -> Figure:
    """Return Fig. 14: the parts of the set-up, and the parts of Slipscale for each."""
    figure, axes = canvas(size=(8.2, 3.8))
    for start, end in LINKS:
        axes.plot(
            *zip(BENCH[start][0], BENCH[end][0], strict=True), color=GREY, linewidth=1, zorder=1
        )
    for at, name, part in BENCH:
        axes.text(
            at[0],
            at[1],
            f"{name}\n\n$\\it{{Slipscale:}}$\n{part.replace(', ', ',' + chr(10), 1)}",
            ha="center",
            va="center",
            fontsize=8.5,
            bbox={"boxstyle": "round,pad=0.5", "facecolor": "white", "edgecolor": BLUE},
        )
    axes.set(xlim=(0, 1), ylim=(0, 1), title="The experiment's set-up, and the parts of Slipscale")
    axes.set_axis_off()
    return figure


#: Figures of this module, keyed by the paper's name.
DRAWINGS = {
    "fig1": plate_figure,
    "fig2": profile_figure,
    "fig6": section_figure,
    "fig7": bending_figure,
    "fig10": mesh_figure,
    "fig13": measured_mode_figure,
    "fig14": bench_figure,
}
