"""Plot the results of the plate models, as in Figs. 8, 9, 11 and 12 of the paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from slipscale.figure_style import BLUE, GREEN, GREY, INK, ORANGE, VERMILION, canvas, note, styled
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.paper_study import Harmonic, harmonic
from slipscale.hardware.plate.vibration import Modes, surface_response_um
from slipscale.stimuli.surface import pp_from_peak

MODE_EXAGGERATION = 0.06  # height of the drawn mode, as a fraction of the plate's length


@styled
def deflection_figure(
    section: BeamSection, voltage_v: float = 15.0, wanted_um_peak: float = 1.5
) -> Any:
    """Plot Fig. 8: dynamic deflection against half-wavelength."""
    figure, axes = canvas()
    half_wave = np.linspace(2, 20, 200)
    axes.plot(half_wave, section.dynamic_deflection_um_peak(half_wave, voltage_v), color=BLUE)
    least = section.half_wave_for_amplitude_mm(wanted_um_peak, voltage_v)
    axes.axhline(wanted_um_peak, color=GREY, linestyle="--", linewidth=1)
    axes.axvspan(2, least, color="#F0F0F0", zorder=0)
    axes.plot([least], [wanted_um_peak], "o", color=VERMILION)
    note(
        axes,
        f"{wanted_um_peak:g} µm needs λ/2 ≥ {least:.2f} mm",
        (3, 0.55 * float(section.dynamic_deflection_um_peak(20, voltage_v))),
        (least, wanted_um_peak),
    )
    axes.set(
        xlabel="Half-wavelength λ/2 (mm)",
        ylabel="Dynamic deflection (µm peak)",
        xlim=(2, 20),
        ylim=(0, None),
        title=f"Deflection at resonance, β = {section.beta:g}, {voltage_v:g} V",
    )
    return figure


@styled
def frequency_figure(
    printed: BeamSection,
    wide: BeamSection,
    numerical_khz: Mapping[float, float] | None = None,
    *,
    floor_hz: float = 25_000.0,
    least_mm: float | None = None,
    measured: tuple[float, float] | None = None,
    harmonic_peak: tuple[float, float] | None = None,
) -> Any:
    """Plot Fig. 9: resonance frequency against half-wavelength, from three models.

    Parameters
    ----------
    printed, wide : BeamSection
        Beam as modelled in the paper, and beam in plane strain.
    numerical_khz : mapping of float to float, optional
        Finite-element frequencies in kHz, keyed by half-wavelength in mm.
    floor_hz : float
        Lowest frequency allowed by the squeeze number.
    least_mm : float, optional
        Shortest half-wavelength allowed by the amplitude. If given, the admissible range is shaded.
    measured : tuple of 2 floats, optional
        Half-wavelength in mm and frequency in kHz of a measured plate.
    harmonic_peak : tuple of 2 floats, optional
        Half-wavelength in mm, and frequency in kHz of the peak in a harmonic analysis of the whole
        plate.
    """
    figure, axes = canvas()
    half_wave = np.linspace(8, 21, 200)
    axes.plot(
        half_wave, printed.frequency_hz(half_wave) / 1e3, color=BLUE, label="Euler–Bernoulli (38)"
    )
    axes.plot(
        half_wave,
        wide.timoshenko_frequency_hz(half_wave) / 1e3,
        color=ORANGE,
        linestyle="--",
        label="Timoshenko, plane strain (ours)",
    )
    if numerical_khz:
        axes.plot(
            list(numerical_khz), list(numerical_khz.values()), "s", color=GREEN, label="3-D FE"
        )
    if measured:
        axes.plot(
            *measured, "o", color=VERMILION, markerfacecolor="none", markersize=9, label="measured"
        )
    if harmonic_peak:
        axes.plot(
            *harmonic_peak, "x", color=INK, markersize=8, label="whole plate, harmonic analysis"
        )
    axes.axhline(floor_hz / 1e3, color=GREY, linestyle=":", linewidth=1.2)
    axes.text(20.9, floor_hz / 1e3 + 0.7, f"{floor_hz / 1e3:.3g} kHz", ha="right", color=GREY)
    if least_mm is not None:
        most = wide.timoshenko_half_wave_mm(floor_hz)
        if most > max(least_mm, 8):
            axes.axvspan(max(least_mm, 8), most, color="#E3F1EA", zorder=0)
            axes.text(
                (max(least_mm, 8) + most) / 2,
                2.0,
                f"admissible to {most:.2f} mm\n(Timoshenko)",
                ha="center",
                color=GREEN,
            )
    axes.set(
        xlabel="Half-wavelength λ/2 (mm)",
        ylabel="Natural frequency (kHz)",
        xlim=(8, 21),
        ylim=(0, None),
        title="Natural frequency of a half-wave section",
    )
    axes.legend(loc="upper right")
    return figure


@styled
def mode_figure(found: Modes, mode: int | None = None, *, title: str | None = None) -> Any:
    """Plot Fig. 11: the shape of a mode on the touch surface, in perspective and from above.

    Parameters
    ----------
    found : Modes
        Modes of a whole plate.
    mode : int, optional
        Index of the mode; by default, the driven mode.
    title : str, optional
        Title; by default, the frequency of the mode.
    """
    from matplotlib.figure import Figure

    index = found.driven if mode is None else mode
    x, y, w = _surface(found, index)
    figure = Figure(figsize=(7.4, 8.0), layout="constrained")
    panels = figure.add_gridspec(2, 1, height_ratios=(1.5, 1))
    upper = figure.add_subplot(panels[0], projection="3d")
    height = MODE_EXAGGERATION * found.parts.layout.length_mm
    drawn = upper.plot_surface(
        x,
        y,
        w * height,
        facecolors=_colours(w),
        rstride=1,
        cstride=1,
        linewidth=0.15,
        edgecolor="#55555560",
        antialiased=True,
        shade=False,
        rasterized=True,  # Writing 10,000 faces as vectors would take half a minute.
    )
    drawn.set_clip_on(False)
    upper.set_box_aspect((np.ptp(x), np.ptp(y), 2 * height), zoom=1.3)
    upper.view_init(elev=32, azim=-62)
    upper.set_axis_off()
    khz = found.frequency_hz[index] / 1e3
    upper.set_title(title or f"Driven mode, {khz:.2f} kHz")

    lower = figure.add_subplot(panels[1])
    image = lower.pcolormesh(
        x, y, w, cmap="PuOr", vmin=-1, vmax=1, shading="gouraud", rasterized=True
    )
    lower.contour(x, y, w, levels=[0.0], colors=INK, linewidths=1.0)
    lower.grid(visible=False)
    lower.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    lower.set_title("Touch surface from above; black: nodal lines", fontsize=10)
    figure.colorbar(image, ax=lower, label="w / largest w", shrink=0.85)
    return figure


@styled
def amplitude_map_figure(found: Modes, *, voltage_v: float = 15.0) -> Any:
    """Plot the amplitude on the touch surface at resonance, with nodal lines.

    Parameters
    ----------
    found : Modes
        Modes of the plate; the figure shows their superposition.
    voltage_v : float
        Drive voltage in V peak.
    """
    edge = harmonic(found, voltage_v=voltage_v)
    loss = 1 / found.parts.layout.ceramic.quality_factor
    top, amplitude_um_peak = surface_response_um(found, edge.peak_hz, voltage_v, loss)
    # On nodal lines, the component in phase with the largest amplitude is zero.
    largest = amplitude_um_peak[np.argmax(np.abs(amplitude_um_peak))]
    together = np.real(amplitude_um_peak * np.conj(largest) / np.abs(largest))
    x, y, w = _on_a_grid(found, top, together)
    amplitude_um_pp = pp_from_peak(1.0) * np.abs(w)
    figure, axes = canvas()
    image = axes.pcolormesh(
        x, y, amplitude_um_pp, cmap="viridis", vmin=0, shading="gouraud", rasterized=True
    )
    axes.contour(x, y, w, levels=[0.0], colors="white", linewidths=1.0)
    axes.grid(visible=False)
    axes.set(
        xlabel="x (mm)",
        ylabel="y (mm)",
        aspect="equal",
        title=f"{edge.peak_hz / 1e3:.2f} kHz, {voltage_v:g} V peak; white: nodal lines",
    )
    figure.colorbar(image, ax=axes, label="Amplitude (µm peak to peak)", orientation="horizontal")
    return figure


def _surface(found: Modes, index: int) -> tuple[Any, Any, Any]:
    """Interpolate a mode on a fine grid; return x and y (mm) and w, scaled to a maximum of 1."""
    top = found.parts.on_top
    x, y, w = _on_a_grid(found, top, found.shape[index, 2, top])
    return x, y, w / np.nanmax(np.abs(w))


def _on_a_grid(found: Modes, top: Any, w: Any) -> tuple[Any, Any, Any]:
    from scipy.interpolate import griddata

    parts = found.parts
    at = parts.nodes[:2, top] * 1e3
    half = np.array([parts.layout.length_mm, parts.layout.width_mm]) / 2
    if parts.quarter:  # Mirrored points keep the interpolation smooth across planes of symmetry.
        for axis, mirror in enumerate(parts.mirrors):
            other = at.copy()
            other[axis] *= -1
            at, w = np.concatenate([at, other], axis=1), np.concatenate([w, mirror * w])
        at, unique = np.unique(np.round(at, 6), axis=1, return_index=True)
        w = w[unique]
    x, y = np.meshgrid(np.linspace(-half[0], half[0], 131), np.linspace(-half[1], half[1], 77))
    smooth, nearest = (griddata(at.T, w, (x, y), method=method) for method in ("cubic", "nearest"))
    # The edge of a disc is beyond the outermost nodes.
    on_plate = parts.layout.outline.holds(x, y)
    return x, y, np.where(on_plate, np.where(np.isnan(smooth), nearest, smooth), np.nan)


def _colours(w: Any) -> Any:
    from matplotlib import colormaps

    return colormaps["PuOr"]((w + 1) / 2)


@styled
def harmonic_figure(
    curves: Mapping[str, Harmonic],
    published: tuple[float, float] | None = None,
    *,
    voltage_v: float = 15.0,
) -> Any:
    """Plot Fig. 12: amplitude at a point of the touch surface against frequency.

    Parameters
    ----------
    curves : mapping of str to Harmonic
        Responses by name.
    published : tuple of 2 floats, optional
        Frequency in kHz and amplitude in µm peak to peak of a published peak.
    voltage_v : float
        Drive voltage in V peak, for the title.
    """
    figure, axes = canvas()
    styles = ((BLUE, "-"), (ORANGE, "--"), (GREEN, "-."), (VERMILION, ":"))
    for (name, curve), (colour, dash) in zip(curves.items(), styles, strict=False):
        axes.plot(
            curve.frequency_hz / 1e3,
            pp_from_peak(curve.amplitude_um_peak),
            color=colour,
            linestyle=dash,
            label=f"{name}: {curve.peak_um_pp:.2f} µm at {curve.peak_hz / 1e3:.2f} kHz",
        )
    if published:
        axes.plot(*published, "D", color=INK, label="published peak")
    axes.set(
        xlabel="Frequency (kHz)",
        ylabel="Vertical amplitude (µm peak to peak)",
        ylim=(0, None),
        title=f"Harmonic response, {voltage_v:g} V",
    )
    axes.margins(x=0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16))
    return figure
