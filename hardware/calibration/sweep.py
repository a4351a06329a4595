"""Run the calibration sweeps: coarse and fine frequency sweeps, and a voltage sweep.

Each sweep runs upward and then downward, so that warming and hysteresis appear in the residuals.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pydantic import ValidationError

from slipscale.faults import UserError
from slipscale.faults.validation import in_words
from slipscale.hardware.calibration.fit import fit_gain, fit_resonance
from slipscale.hardware.calibration.record import (
    Calibration,
    Device,
    DriveChain,
    Gain,
    Point,
    Provenance,
    Resonance,
)
from slipscale.hardware.calibration.soundness import unsound

if TYPE_CHECKING:
    # Function that returns the amplitude in µm p-p at a frequency in Hz and a voltage in V, or None
    # to repeat the previous point.
    Measure = Callable[[float, float], float | None]

COARSE_POINTS, FINE_POINTS, VOLTAGE_POINTS = 41, 21, 12
FINE_WIDTHS = 1.5  # width of the fine sweep to either side, in half-power widths


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepPlan:
    """Frequency and voltage ranges for the sweeps of a calibration.

    ``span_hz`` is half the width of the frequency range. Voltages are those at the plate, in the
    calibration's convention.
    """

    centre_hz: float = 30_500.0
    span_hz: float = 1_500.0
    sweep_voltage_v: float = 5.0
    max_voltage_v: float = 16.0


def sweep(plan: SweepPlan, measure: Measure) -> tuple[Point, ...]:
    """Measure all points of a calibration in the prescribed order.

    Parameters
    ----------
    plan : SweepPlan
        Ranges of the sweeps.
    measure : callable
        Function that takes a frequency in Hz and a voltage in V, drives the plate, and returns the
        reading in µm p-p, or None to repeat the previous point of the same sweep.
    """

    def measured(kind: str, drives: Sequence[tuple[float, float]]) -> list[Point]:
        points: list[Point] = []
        while len(points) < len(drives):
            frequency_hz, voltage_v = drives[len(points)]
            read = {"frequency_hz": frequency_hz, "voltage_v": voltage_v}
            amplitude_um_pp = measure(frequency_hz, voltage_v)
            if amplitude_um_pp is not None:
                read["amplitude_um_pp"] = amplitude_um_pp
                points.append(Point.model_validate({"sweep": kind, **read}))
            elif points:
                points.pop()
        return points

    def frequencies(centre_hz: float, span_hz: float, count: int) -> list[tuple[float, float]]:
        steps = np.linspace(centre_hz - span_hz, centre_hz + span_hz, count)
        return [(round(each, 1), plan.sweep_voltage_v) for each in there_and_back(steps)]

    coarse = measured("coarse", frequencies(plan.centre_hz, plan.span_hz, COARSE_POINTS))
    found = fit_resonance(coarse).resonance
    half_span_hz = FINE_WIDTHS * found.frequency_hz / found.quality_factor
    fine = measured("fine", frequencies(found.frequency_hz, half_span_hz, FINE_POINTS))
    resonance_hz = round(fit_resonance(fine).resonance.frequency_hz, 1)
    steps = np.linspace(0, plan.max_voltage_v, VOLTAGE_POINTS + 1)[1:]
    voltage = measured("voltage", [(resonance_hz, each) for each in there_and_back(steps)])
    return (*coarse, *fine, *voltage)


def there_and_back(steps: Iterable[float]) -> list[float]:
    """Return the steps in order, followed by the same steps in reverse order.

    >>> there_and_back([1, 2])
    [1.0, 2.0, 2.0, 1.0]
    """
    up = [float(each) for each in steps]
    return up + up[::-1]


def fitted(points: Sequence[Point]) -> tuple[Resonance, Gain]:
    """Fit resonance and gain to the points of a calibration.

    Raises
    ------
    UserError
        If the points do not contain a resonance or a voltage sweep.
    """
    fine = [each for each in points if each.sweep == "fine"]
    coarse = [each for each in points if each.sweep == "coarse"]
    resonance = fit_resonance(fine or coarse).resonance
    return resonance, fit_gain([each for each in points if each.sweep == "voltage"])


def calibration_from(
    points: Sequence[Point], *, device: Device, made: Provenance, drive: DriveChain
) -> Calibration:
    """Fit all points, and return the calibration.

    Raises
    ------
    UserError
        If the points do not contain a resonance or a voltage sweep, or if the readings indicate
        that the plate changed or is faulty.
    """
    resonance, gain = fitted(points)
    made_with = {
        "source_max_v": gain.voltage_max_v / drive.amplifier_gain,
        "plate_max_v_peak": gain.voltage_max_v * drive.v_peak_per_volt,
    }
    try:
        calibration = Calibration(
            device=device,
            made=made,
            drive=drive.model_copy(update=made_with),
            resonance=resonance,
            gain=gain,
            points=tuple(points),
        )
    except ValidationError as error:
        raise UserError("calibration: {faults}", faults=in_words(error)) from error
    if faults := unsound(calibration):
        raise UserError("calibration: {faults}", faults="; ".join(faults))
    return calibration
