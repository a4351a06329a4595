"""Plot the paper's Figs. 3, 4 and 5, and the error of the closed-form solution."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from slipscale.figure_style import (
    BLUE,
    CYCLE,
    DASHES,
    GREY,
    INK,
    ORANGE,
    VERMILION,
    canvas,
    note,
    styled,
)
from slipscale.stimuli.film import reynolds, shared_load, squeeze_film
from slipscale.stimuli.film.reynolds import WorkingPoint
from slipscale.stimuli.film.shared_load import NOT_VALIDATED
from slipscale.stimuli.film.squeeze_film import FINGER, ROUGHNESS_UM, Finger
from slipscale.stimuli.surface import peak_from_pp, pp_from_peak

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.stimuli.quantities import Array

WORST_CASE = (3.0, 1.6)  # h_vib in µm peak and h_r in µm of Figs. 3 and 4


@styled
def squeeze_number_figure() -> Figure:
    """Return Fig. 3: squeeze number against frequency for h_r = 1.6 µm and h_vib = 3 µm."""
    figure, axes = canvas()
    frequency = np.linspace(1, 60, 60)
    number = squeeze_film.squeeze_number(frequency * 1e3, *WORST_CASE)
    reached = 10 / number[0]
    axes.plot(frequency, number, color=BLUE)
    axes.axhline(10, color=GREY, linestyle="--", linewidth=1)
    axes.plot([25], squeeze_film.squeeze_number([25e3], *WORST_CASE), "o", color=VERMILION)
    note(axes, "the paper's criterion: 25 kHz, σ = 11.7", (28, 6.5), (25, 11.5))
    note(axes, f"σ = 10 is reached at {reached:.1f} kHz", (3, 15), (reached, 10))
    axes.set(
        xlabel="Frequency (kHz)",
        ylabel="Squeeze number σ",
        xlim=(0, 60),
        ylim=(0, None),
        title="Squeeze number, h_r = 1.6 µm, h_vib = 3 µm peak",
    )
    return figure


@styled
def film_figure() -> Figure:
    """Return Fig. 4: film thickness under the finger, and mean pressure from both solutions."""
    figure, (upper, lower) = canvas(2, 1, (6.6, 5.6), sharex=True)
    vibration, roughness = WORST_CASE
    x = np.linspace(-1.05, 1.05, 2000)
    thickness = squeeze_film.film_thickness_um(x, np.pi, vibration, roughness)
    floor = roughness + vibration
    upper.fill_between(x, thickness, 115, color="#F2D6C4", linewidth=0)
    upper.plot(x, thickness, color=VERMILION)
    upper.fill_between(x, 0, floor, color="#D8E6F0", linewidth=0)
    upper.axhline(floor, color=BLUE, linewidth=1)
    upper.text(0, 60, "film", ha="center", color=INK)
    upper.text(0.35 / 2, 108, "finger", ha="center", color=INK)
    upper.text(0, floor + 4, "h_r + h_vib", ha="center", color=INK, fontsize=8)
    upper.set(
        ylabel="Film thickness (µm)",
        ylim=(0, 115),
        title="Film thickness with the plate at its highest point",
    )

    finger_pressure = squeeze_film.NORMAL_FORCE_N / (FINGER.contact_length_mm * 1e-3) ** 2 / 1e5
    closed = squeeze_film.mean_pressure(x, vibration, roughness)
    state = reynolds.solve(
        WorkingPoint(amplitude_um_peak=vibration, roughness_um=roughness, frequency_hz=40_000)
    )
    at = state.position * FINGER.contact_length_mm
    lower.plot(x, closed, color=BLUE, label="closed form, equation (13), from the paper")
    lower.plot(
        np.concatenate([-at[::-1], at]),
        np.concatenate([state.mean_pressure[::-1], state.mean_pressure]),
        color=ORANGE,
        linestyle="--",
        label="our solution of Reynolds equation (3) at 40 kHz",
    )
    lower.axhline(1 + finger_pressure, color=GREY, linestyle=":", linewidth=1.2)
    lower.text(
        0.7,
        1 + finger_pressure + 0.006,
        "finger, 0.5 N",
        ha="center",
        color=GREY,
        fontsize=9,
    )
    lower.set(
        xlabel="Position under the finger, from its centre (mm)",
        ylabel="Mean pressure / p0",
        xlim=(-1.05, 1.05),
        title="Mean pressure over one period",
    )
    lower.legend(loc="upper center", bbox_to_anchor=(0.5, -0.28), ncols=1)
    return figure


@styled
def friction_figure() -> Figure:
    """Return Fig. 5: relative friction against amplitude for four roughnesses, at 0.5 N."""
    figure, axes = canvas()
    amplitude = np.linspace(0, 5, 201)
    for roughness, colour, dash in zip(ROUGHNESS_UM, CYCLE, DASHES, strict=True):
        friction = squeeze_film.relative_friction(amplitude, roughness, 40_000).relative_friction
        axes.plot(amplitude, friction, color=colour, linestyle=dash, label=f"{roughness} µm")
    axes.axhspan(-0.6, 0, color="#F0F0F0", zorder=0)
    axes.text(0.08, -0.3, "below 0: the finger would levitate", color=GREY, fontsize=9)
    half = float(squeeze_film.relative_friction(1.5, 0.6, 40_000).relative_friction)
    axes.plot([1.5], [half], "D", color=INK, label="0.6 µm at 1.5 µm")
    note(axes, f"guideline: about one half\n(ours {half:.2f})", (0.12, 0.08), (1.5, half))
    axes.set(
        xlabel="Vibration amplitude h_vib (µm peak)",
        ylabel="Relative friction µ'/µ",
        xlim=(0, 5),
        ylim=(-0.6, 1.02),
        title="Relative friction, closed form, 0.5 N",
    )
    axes.legend(title="Roughness h_r", loc="upper right")
    return figure


def convergence_data(factors: Array, finger: Finger = FINGER) -> tuple[Array, Array]:
    """Return squeeze numbers, and ratios of numerical to closed-form overpressure.

    Each factor multiplies the frequency in the conditions of the paper: h_r = 0.6 µm, 2.3 µm peak
    to peak, 30.5 kHz.
    """
    points = [
        WorkingPoint(
            amplitude_um_peak=peak_from_pp(2.3),
            roughness_um=0.6,
            frequency_hz=30_500 * float(factor),
            finger=finger,
        )
        for factor in factors
    ]
    states = reynolds.sweep(points, workers=1)
    closed = float(squeeze_film.mean_overpressure(peak_from_pp(2.3), 0.6, finger))
    return (
        np.array([state.squeeze_number for state in states]),
        np.array([state.overpressure for state in states]) / closed,
    )


@styled
def closed_form_figure() -> Figure:
    """Return a figure that compares friction and overpressure between the two solutions."""
    figure, (left, right) = canvas(1, 2, (9.6, 4.2))
    peak = np.linspace(0, 1.15, 24)
    amplitude = pp_from_peak(peak)
    with warnings.catch_warnings():
        warnings.simplefilter("error", squeeze_film.ClosedFormWarning)
        closed = squeeze_film.relative_friction(peak, 0.6, 30_500).relative_friction
    points = [
        WorkingPoint(amplitude_um_peak=a, roughness_um=0.6, frequency_hz=30_500) for a in peak
    ]
    states = reynolds.sweep(points, workers=1)
    pressed = squeeze_film.NORMAL_FORCE_N / (FINGER.contact_length_mm * 1e-3) ** 2
    solved = 1 - np.array([state.overpressure for state in states]) * 1e5 / pressed
    left.plot(amplitude, closed, color=BLUE, label="closed form (13)")
    left.plot(amplitude, solved, color=ORANGE, linestyle="--", label="Reynolds (3), ours")
    least, most = zip(*(shared_load.band(float(a)) for a in peak), strict=True)
    left.fill_between(
        amplitude, least, most, color=GREY, alpha=0.25, linewidth=0, label=NOT_VALIDATED
    )
    for level in (0.5, 1.2, 2.3):
        left.axvline(level, color=GREY, linewidth=0.8, linestyle=":")
    left.text(0.53, 0.03, "the experiment's\namplitudes", color=GREY, fontsize=9, va="bottom")
    left.set(
        xlabel="Amplitude (µm peak to peak)",
        ylabel="Relative friction µ'/µ",
        xlim=(0, 2.35),
        ylim=(0, 1.02),
        title="At the plate's operating point",
    )
    left.legend(loc="lower left", bbox_to_anchor=(0, 0.12), fontsize=8)

    numbers, ratio = convergence_data(np.geomspace(0.03, 700, 12))
    flat_numbers, flat = convergence_data(
        np.geomspace(0.0004, 20, 12), Finger(ridge_amplitude_um=0.0)
    )
    right.plot(
        numbers, ratio, "o-", color=ORANGE, markersize=4, label="ridged finger (ours: 29 ridges)"
    )
    right.plot(flat_numbers, flat, "s--", color=INK, markersize=4, label="flat finger")
    right.axvline(10, color=VERMILION, linewidth=1, linestyle=":")
    right.text(8.2, 0.08, "paper: 10\nsuffices", color=VERMILION, fontsize=9, ha="right")
    right.set(
        xscale="log",
        xlabel="Squeeze number σ",
        ylabel="Overpressure: Reynolds / closed form",
        ylim=(0, 1.2),
        title="Where the two curves meet",
    )
    right.legend(loc="lower right")
    return figure
