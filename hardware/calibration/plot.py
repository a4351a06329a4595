"""Plot a calibration: resonance curve and amplitude against voltage, with residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.figure_style import BLUE, VERMILION, canvas, styled
from slipscale.hardware.calibration.fit import response

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from slipscale.hardware.calibration.record import Calibration, Point

MEASURED, FITTED = BLUE, VERMILION


@styled
def draw(calibration: Calibration) -> Figure:
    """Plot both sweeps of a calibration with their fits."""
    figure, axes = canvas(2, 2, (9, 5), sharex="col", height_ratios=[3, 1])
    resonance, gain = calibration.resonance, calibration.gain
    sweep = [each for each in calibration.points if each.sweep != "voltage"]
    volts = sweep[0].voltage_v
    height_um = gain.um_pp_per_v * volts

    def curve(frequency_hz: np.ndarray) -> np.ndarray:
        return response(frequency_hz, resonance.frequency_hz, resonance.quality_factor, height_um)

    frequency_hz = np.array([each.frequency_hz for each in sweep])
    fine_hz = np.linspace(frequency_hz.min(), frequency_hz.max(), 600)
    _panel(axes[:, 0], frequency_hz / 1e3, sweep, curve(frequency_hz))
    axes[0, 0].plot(fine_hz / 1e3, curve(fine_hz), color=FITTED, label="fit", zorder=1)
    axes[0, 0].set_title(
        f"{resonance.frequency_hz / 1e3:.4f} kHz ± {resonance.frequency_ci95_hz:.1f} Hz,"
        f"  Q = {resonance.quality_factor:.1f} ± {resonance.quality_factor_ci95:.1f}"
        f"   (at {volts:g} {calibration.drive.voltage_convention})",
        fontsize="medium",
    )
    axes[1, 0].set_xlabel("drive frequency (kHz)")

    linear = [each for each in calibration.points if each.sweep == "voltage"]
    voltage_v = np.array([each.voltage_v for each in linear])
    _panel(axes[:, 1], voltage_v, linear, gain.um_pp_per_v * voltage_v)
    ends = np.array([0, voltage_v.max()])
    axes[0, 1].plot(ends, gain.um_pp_per_v * ends, color=FITTED, label="fit", zorder=1)
    axes[0, 1].set_title(
        f"{gain.um_pp_per_v * 1e3:.1f} ± {gain.um_pp_per_v_ci95 * 1e3:.1f} nm p-p per volt",
        fontsize="medium",
    )
    axes[1, 1].set_xlabel(f"drive ({calibration.drive.voltage_convention})")
    axes[0, 0].legend()
    device, made = calibration.device, calibration.made
    figure.suptitle(
        f"Plate {device.serial or device.backend}, {made.date}, {made.by}, {made.instrument}"
    )
    return figure


def _panel(pair: np.ndarray, x: np.ndarray, points: list[Point], fitted: np.ndarray) -> None:
    """Plot readings and fit in the upper panel, and residuals in the lower panel."""
    above: Axes = pair[0]
    below: Axes = pair[1]
    measured_um = np.array([each.amplitude_um_pp for each in points])
    above.plot(x, measured_um, "o", ms=4, mfc="none", color=MEASURED, label="measured")
    above.set_ylabel("amplitude (µm p-p)")
    above.set_ylim(bottom=0)
    below.axhline(0, color=FITTED, lw=1)
    below.plot(x, (measured_um - fitted) * 1e3, "o", ms=3, mfc="none", color=MEASURED)
    below.set_ylabel("residual (nm)")
