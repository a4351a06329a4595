"""Check that the readings and values of a calibration are plausible.

A fit alone does not reveal a plate that saturates, an instrument with an offset, a plate that
changed between the upward and the downward sweep, two resonances instead of one, or a wrong unit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from slipscale.faults.message import Message

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.hardware.calibration.record import Calibration, Point

OFFSET = 0.05  # largest offset at 0 V, as a fraction of the largest reading
FALLS = 0.02  # largest decrease between successive voltages, as a fraction of the largest reading
DRIFT = 0.03  # largest relative difference between downward and upward readings
LOWEST = 0.2  # fraction of the largest voltage below which noise hides a drift
CURVED = 0.08  # In the upper half of the sweep, the gain may be lower by twice this fraction.
SECOND_PEAK = 0.1  # largest deviation from one resonance, as a fraction of the peak
FEWEST = 4

# Default plausible ranges: (name, lowest, highest, unit).
BOUNDS: Mapping[str, tuple[float, float]] = {
    "resonance_hz": (15_000.0, 100_000.0),
    "quality_factor": (5.0, 2_000.0),
    "um_pp_per_v_peak": (0.005, 2.0),
}
# Ratios of wrong to correct gain that result from mistaken units.
MISTAKES: tuple[tuple[float, str], ...] = (
    (1000.0, "nanometres mistaken for micrometres, or µm/s for mm/s"),
    (0.001, "millivolts mistaken for volts, or m/s for mm/s"),
    (2.0, "peak-to-peak values mistaken for peak values"),
    (0.5, "peak values mistaken for peak-to-peak values"),
    (math.sqrt(2), "peak values mistaken for RMS values"),
    (1 / math.sqrt(2), "RMS values mistaken for peak values"),
)
MISTAKEN = 0.08  # relative tolerance for the ratios in `MISTAKES`
CHANGED = 0.2  # relative change of the gain between two calibrations of one plate


class Sweep(NamedTuple):
    """Voltage sweep: voltages in V and readings in µm p-p, in the order of measurement."""

    voltage_v: NDArray[np.float64]
    reading_um: NDArray[np.float64]


def unsound(calibration: Calibration) -> list[str]:
    """Describe the problems in a calibration's readings, one sentence per problem."""
    linear = [each for each in calibration.points if each.sweep == "voltage"]
    sweep = Sweep(
        np.array([each.voltage_v for each in linear]),
        np.array([each.amplitude_um_pp for each in linear]),
    )
    if len(linear) < FEWEST or sweep.reading_um.max() <= 0:
        return []
    return [*(fault for rule in RULES for fault in rule(sweep)), *_second_peak(calibration)]


def _saturates(sweep: Sweep) -> Iterator[str]:
    middle = sweep.voltage_v.max() / 2
    low, high = sweep.voltage_v <= middle, sweep.voltage_v > middle
    if low.sum() < FEWEST or high.sum() < FEWEST:
        return
    below = float(
        sweep.voltage_v[low] @ sweep.reading_um[low] / (sweep.voltage_v[low] @ sweep.voltage_v[low])
    )
    above = float(np.polyfit(sweep.voltage_v[high], sweep.reading_um[high], 1)[0])
    if below > 0 and above < (1 - 2 * CURVED) * below:
        yield (
            f"the plate saturates: its gain is {above:.4g} µm p-p per volt above {middle:g} "
            f"V, but {below:.4g} below {middle:g} V; limit the sweep to lower voltages"
        )


def _falls(sweep: Sweep) -> Iterator[str]:
    steps = sorted({float(each) for each in sweep.voltage_v})
    means = [float(sweep.reading_um[sweep.voltage_v == each].mean()) for each in steps]
    for (v0, before), (v1, after) in pairwise(zip(steps, means, strict=True)):
        if before - after > FALLS * sweep.reading_um.max():
            yield f"the amplitude falls from {before:.3f} at {v0:g} V to {after:.3f} µm at {v1:g} V"
            return


def _offset(sweep: Sweep) -> Iterator[str]:
    if len(set(sweep.voltage_v)) < FEWEST:
        return
    slope, offset = np.polyfit(sweep.voltage_v, sweep.reading_um, 1)
    if abs(offset) > OFFSET * sweep.reading_um.max() and slope > 0:
        yield f"the readings have an offset of {offset:.3f} µm p-p at 0 V; zero the instrument"


def _drifts(sweep: Sweep) -> Iterator[str]:
    apart = []
    for voltage in set(sweep.voltage_v[sweep.voltage_v > LOWEST * sweep.voltage_v.max()]):
        read = sweep.reading_um[sweep.voltage_v == voltage]
        apart.append(float(read[-1] / read[0]) - 1 if len(read) > 1 and read[0] > 0 else 0.0)
    drift = float(np.mean(apart))
    if abs(drift) > DRIFT:
        yield (
            f"the plate changed during the sweep: downward readings differ by {drift:+.1%} "
            "from upward readings; let the plate warm up"
        )


RULES: tuple[Callable[[Sweep], Iterator[str]], ...] = (_saturates, _falls, _offset, _drifts)


def _second_peak(calibration: Calibration) -> Iterator[str]:
    """Yield a message if the frequency sweep does not follow the fitted resonance."""
    fine = [each for each in calibration.points if each.sweep == "fine"]
    swept: Sequence[Point] = fine or [each for each in calibration.points if each.sweep == "coarse"]
    if len(swept) < FEWEST:
        return
    places = sorted({each.frequency_hz for each in swept})
    left = {
        place: np.mean(
            [
                each.amplitude_um_pp - calibration.expected_um_pp(each)
                for each in swept
                if each.frequency_hz == place
            ]
        )
        for place in places
    }
    worst_hz = max(places, key=lambda place: abs(left[place]))
    largest_um = max(each.amplitude_um_pp for each in swept)
    if abs(left[worst_hz]) > SECOND_PEAK * largest_um:
        yield (
            f"the frequency sweep does not follow one resonance: at {worst_hz:g} Hz the amplitude "
            f"differs by {left[worst_hz]:+.3f} µm p-p from the fit"
        )


def implausible(
    calibration: Calibration, expected: Mapping[str, tuple[float, float] | None]
) -> list[str]:
    """Describe values outside the range expected for the plate, one sentence per value.

    Parameters
    ----------
    calibration : Calibration
    expected : mapping
        Bounds by name, as in the ``[expected]`` table of a plate file. Missing names use `BOUNDS`.
    """
    found = []
    for name, value in calibration.characteristics().items():
        bounds = expected.get(name) or BOUNDS[name]
        if not bounds[0] <= value <= bounds[1]:
            whose = "the plate file expects" if expected.get(name) else "plausible values are"
            found.append(f"{name} is {value:g}, but {whose} {bounds[0]:g} to {bounds[1]:g}")
    return found


def mistake(ratio: float, amplifier_gain: float) -> str:
    """Return the unit error that would explain the ratio of two gains, or "" if there is none.

    >>> mistake(0.5, 1.0)
    'peak values mistaken for peak-to-peak values'
    >>> mistake(20.5, 20.0)
    'the voltage before the amplifier mistaken for the voltage at the plate'
    """
    gains = (
        (amplifier_gain, "the voltage before the amplifier mistaken for the voltage at the plate"),
    )
    for factor, what in (*MISTAKES, *(gains if amplifier_gain != 1 else ())):
        if abs(ratio / factor - 1) < MISTAKEN:
            return str(what)
    return ""


def changed(calibration: Calibration, before: Calibration) -> str:
    """Describe how the gain differs from the plate's previous calibration, or return ""."""
    ratio: float = calibration.um_pp_per_v_peak / before.um_pp_per_v_peak
    if 1 / (1 + CHANGED) <= ratio <= 1 + CHANGED:
        return ""
    why = mistake(ratio, calibration.drive.amplifier_gain)
    guess = ""
    if why:
        cause = "; a possible cause of this factor of {ratio:.3g}: {why}"
        guess = Message(cause, ratio=ratio, why=why)
    return Message(
        "the gain is {um_pp_per_v_peak:.4g} µm p-p per V peak, but "
        "{before_um_pp_per_v_peak:.4g} in the plate's last calibration ({date}){guess}",
        um_pp_per_v_peak=calibration.um_pp_per_v_peak,
        before_um_pp_per_v_peak=before.um_pp_per_v_peak,
        date=before.made.date,
        guess=guess,
    )
