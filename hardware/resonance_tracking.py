"""Track a drifting resonance with measurements at three frequencies.

Near one resonance, the amplitude at constant drive voltage is

    A(f) = A0 / sqrt(1 + 4 Q² (f - f0)² / f0²).

As a function of f, 1/A² is a parabola with its vertex at f0, so three points determine it. A driver
board follows the resonance automatically. A function generator or a sound card drives the plate at
the calibrated frequency, but the resonance drifts by 5 Hz per kelvin as the plate warms up. A
detuning of 52 Hz reduces the amplitude by 2 % if Q = 60, and by 17 % if Q = 200.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from slipscale.faults import UserError
from slipscale.hardware.errors import OffCalibration, PlateRefused

if TYPE_CHECKING:
    from slipscale.hardware.calibration.record import Resonance
    from slipscale.hardware.driver import PlateDriver

SWEEP_UM_PP = 0.3  # amplitude of the sweep at resonance, hardly perceptible
POINTS = (-0.5, 0.0, 0.5)  # frequency offsets of the points, in half-widths of the resonance
AGREES = 0.15  # allowed relative deviation of the peak from the calibration
LARGEST_SHIFT = 1.0  # largest drift, in half-widths of the resonance


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracking:
    """Result of resonance tracking.

    Parameters
    ----------
    before_hz, frequency_hz : float
        Drive frequency before and after tracking; unchanged if the measured points were rejected.
    points : tuple of (float, float)
        Pairs of frequency in Hz and measured amplitude in µm peak to peak.
    refused : str
        Reason why the points were rejected; empty if they were accepted.
    """

    before_hz: float
    frequency_hz: float
    points: tuple[tuple[float, float], ...]
    refused: str = ""


def half_width_hz(resonance: Resonance) -> float:
    """Return the detuning at which the amplitude falls to 71 % of its value at resonance."""
    return resonance.frequency_hz / (2 * resonance.quality_factor)


def vertex(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the frequency and amplitude of the resonance curve through three points.

    Raises
    ------
    UserError
        If the points are not on a resonance curve.

    Examples
    --------
    >>> import math
    >>> resonance = lambda f: 0.3 / math.sqrt(1 + 4 * 60**2 * (f - 30_480) ** 2 / 30_480**2)
    >>> found = vertex([(f, resonance(f)) for f in (30_373, 30_500, 30_627)])
    >>> round(found[0], 6), round(found[1], 6)
    (30480.0, 0.3)
    """
    if any(not (math.isfinite(a) and a > 0) for _, a in points):
        raise UserError("an amplitude of 0 was measured")
    (f0, y0), (f1, y1), (f2, y2) = ((f, 1 / a**2) for f, a in points)
    first, second = (y1 - y0) / (f1 - f0), (y2 - y1) / (f2 - f1)
    curvature = (second - first) / (f2 - f0)
    if curvature <= 0:
        raise UserError("the amplitudes have no maximum")
    top_hz = (f0 + f1) / 2 - first / (2 * curvature)
    top = y1 - curvature * (f1 - top_hz) ** 2
    if top <= 0:
        raise UserError("the amplitudes do not fit a single resonance")
    return top_hz, 1 / math.sqrt(top)


def track(plate: PlateDriver, measure_um_pp: Callable[[], float]) -> Tracking:
    """Measure the resonance, set it as the drive frequency from now on, and silence the plate.

    Parameters
    ----------
    plate : PlateDriver
        Connected and calibrated driver. The plate's limits also apply during the measurements.
    measure_um_pp : callable
        Function that returns the settled amplitude, measured by an instrument, in µm peak to peak.

    Raises
    ------
    PlateRefused
        If the plate follows its resonance automatically or is not calibrated.
    OffCalibration
        If the amplitude at resonance differs from the calibration's prediction, which means that
        the amplifier, the plate or the instrument has changed.
    PlateFault
        If the hardware fails. The plate is silenced.
    """
    if not plate.tracks or plate.calibration is None:
        raise PlateRefused(
            "backend '{plate_name}' has no resonance to track", plate_name=plate.name
        )
    resonance = plate.calibration.resonance
    before_hz = plate.tracked_hz or resonance.frequency_hz
    half_hz = half_width_hz(resonance)
    swept_um_pp = min(SWEEP_UM_PP, plate.limits.level)
    voltage_v = plate.calibration.voltage_v_peak(swept_um_pp)
    points: list[tuple[float, float]] = []
    try:
        for place in POINTS:
            frequency_hz = before_hz + place * half_hz
            plate.excite(frequency_hz=frequency_hz, voltage_v=voltage_v)
            points.append((frequency_hz, measure_um_pp()))
    finally:
        plate.silence()
    now_hz, top_um_pp, refused = before_hz, swept_um_pp, ""
    try:
        now_hz, top_um_pp = vertex(points)
    except UserError as error:
        refused = str(error)
    if not abs(top_um_pp - swept_um_pp) <= AGREES * swept_um_pp:
        raise OffCalibration(
            "at its resonance of {now_hz:.1f} Hz, the plate reaches {top_um_pp:.3f} µm p-p with "
            "{voltage_v:.2f} V peak, but the calibration predicts {swept_um_pp:.3f} µm p-p",
            now_hz=now_hz,
            top_um_pp=top_um_pp,
            voltage_v=voltage_v,
            swept_um_pp=swept_um_pp,
        )
    if abs(now_hz - resonance.frequency_hz) > LARGEST_SHIFT * half_hz:
        refused = (
            f"the resonance of {now_hz:.1f} Hz is more than {half_hz:.0f} Hz away from the "
            f"calibrated {resonance.frequency_hz:.1f} Hz; recalibrate"
        )
    if not refused:
        plate.limits.check_frequency(now_hz)
        plate.tracked_hz = now_hz
    return Tracking(
        before_hz=before_hz,
        frequency_hz=before_hz if refused else now_hz,
        points=tuple(points),
        refused=refused,
    )
