"""Read vibrometer readings from files: amplitudes, velocities or oscilloscope traces.

CSV files contain one row per reading, with the columns ``sweep``, ``frequency_hz``, ``voltage_v``,
and one of `QUANTITIES` for the measured quantity.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import dropwhile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.validation import in_words
from slipscale.hardware.calibration.record import Point

DRIVE_COLUMNS = ("sweep", "frequency_hz", "voltage_v")
UM_PER_MM = 1000.0
PERIODS_MIN = 5.0
SAMPLES_PER_PERIOD_MIN = 4.0
UNEVEN = 0.01  # tolerance for sample intervals, because instruments round printed times


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """Evenly sampled oscilloscope recording.

    Parameters
    ----------
    times_s, volts_v : ndarray, shape (n,)
        Time and voltage of each sample.
    """

    times_s: NDArray[np.float64]
    volts_v: NDArray[np.float64]

    def amplitude_v_peak(self, frequency_hz: float) -> float:
        """Estimate the amplitude of the sine wave at a given frequency by least squares.

        Offsets and components at other frequencies, such as hum, do not affect the estimate.

        Raises
        ------
        ValueError
            If the samples are too far apart or uneven, or cover too few periods.
        """
        steps_s = np.diff(self.times_s)
        step_s = float(np.mean(steps_s))
        if not (step_s > 0 and np.all(np.abs(steps_s - step_s) < UNEVEN * step_s + 1e-15)):
            raise ValueError(
                "the times are not evenly spaced; expected times in seconds at equal intervals"
            )
        if frequency_hz * step_s * SAMPLES_PER_PERIOD_MIN > 1:
            raise ValueError(
                Message(
                    "the samples are {step_s:.3g} s apart; expected at least "
                    "{samples_per_period_min:g} samples per period of {frequency_hz:g} Hz, with "
                    "times in seconds",
                    step_s=step_s,
                    samples_per_period_min=SAMPLES_PER_PERIOD_MIN,
                    frequency_hz=frequency_hz,
                )
            )
        if frequency_hz * step_s * self.times_s.size < PERIODS_MIN:
            raise ValueError(
                Message(
                    "the trace is shorter than {periods_min:g} periods of {frequency_hz:g} Hz",
                    periods_min=PERIODS_MIN,
                    frequency_hz=frequency_hz,
                )
            )
        phase = 2 * np.pi * frequency_hz * (self.times_s - self.times_s[0])
        terms = np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(phase)])
        (cosine, sine, _), *_ = np.linalg.lstsq(terms, self.volts_v, rcond=None)
        return math.hypot(cosine, sine)


def um_pp_from_velocity(velocity_mm_s_peak: float, frequency_hz: float) -> float:
    """Convert a sine's peak velocity to peak-to-peak displacement, 2 v / (2π f).

    >>> round(um_pp_from_velocity(100.0, 30_500.0), 4)
    1.0436
    """
    return velocity_mm_s_peak * UM_PER_MM / (math.pi * frequency_hz)


def read_trace(path: Path) -> Trace:
    """Read an oscilloscope's CSV file.

    Files from different makes of oscilloscope differ in their headers and first columns, but the
    last two fields of each sample line are always a time and a voltage. Lines before the first
    sample are treated as the header.

    Raises
    ------
    ValueError
        If the file cannot be read, contains no samples, or has an invalid line between samples.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise ValueError(error.strerror) from None
    numbered = [(number, _sample(line)) for number, line in enumerate(lines, start=1) if line]
    samples = list(dropwhile(lambda each: each[1] is None, numbered))
    if not samples:
        raise ValueError("no line ends with a time and a voltage")
    pairs = []
    for number, pair in samples:
        if pair is None:
            raise ValueError(
                Message("line {number} does not end with a time and a voltage", number=number)
            )
        pairs.append(pair)
    times_s, volts_v = np.array(pairs).T
    return Trace(times_s=times_s, volts_v=volts_v)


def _sample(line: str) -> tuple[float, float] | None:
    fields = [each.strip() for each in line.replace(";", ",").rstrip(", \t").split(",")]
    try:
        time_s, volts_v = map(float, fields[-2:])
    except ValueError:
        return None
    return (time_s, volts_v) if math.isfinite(time_s) and math.isfinite(volts_v) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class _Reading:
    """Value from a file, with the information required to convert it to an amplitude."""

    text: str
    frequency_hz: float
    folder: Path
    mm_s_per_v: float | None


def _number(reading: _Reading) -> float:
    try:
        value = float(reading.text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(
            Message("'{reading_text}', expected a number, 0 or more", reading_text=reading.text)
        )
    return value


def _of_a_velocity(reading: _Reading) -> float:
    return um_pp_from_velocity(_number(reading), reading.frequency_hz)


def _of_a_trace(reading: _Reading) -> float:
    if reading.mm_s_per_v is None:
        raise UserError(
            "--csv: oscilloscope traces require --mm-s-per-volt, the vibrometer's scale factor"
        )
    try:
        volts_v = read_trace(reading.folder / reading.text).amplitude_v_peak(reading.frequency_hz)
    except ValueError as error:
        raise ValueError(
            Message("'{reading_text}': {error}", reading_text=reading.text, error=error)
        ) from None
    return um_pp_from_velocity(volts_v * reading.mm_s_per_v, reading.frequency_hz)


# Functions that convert a reading to µm peak to peak, keyed by the column of the reading.
QUANTITIES: dict[str, Callable[[_Reading], float]] = {
    "amplitude_um_pp": _number,
    "velocity_mm_s_peak": _of_a_velocity,
    "trace": _of_a_trace,
}


def read_points(path: Path, *, mm_s_per_v: float | None = None) -> tuple[Point, ...]:
    """Read vibrometer readings from a CSV file.

    Parameters
    ----------
    path : Path
        Path of the CSV file. Paths of trace files are relative to the folder of the CSV file.
    mm_s_per_v : float
        Velocity in mm/s per volt of the vibrometer's output; required for traces.

    Raises
    ------
    UserError
        If the file does not exist, does not have exactly one column of `QUANTITIES`, or contains an
        invalid value.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            table = csv.DictReader(file)
            rows, columns = list(table), table.fieldnames or ()
    except (OSError, UnicodeDecodeError) as error:
        raise UserError("--csv {path}: cannot be read ({error})", path=path, error=error) from error
    quantities = [each for each in QUANTITIES if each in columns]
    if len(quantities) != 1:
        raise UserError(
            "--csv {path}: expected one of the columns {quantities}, got {found}",
            path=path,
            quantities=", ".join(QUANTITIES),
            found=" and ".join(quantities) or "none of them",
        )
    return tuple(
        _point(row, quantities[0], f"--csv {path}, line {line}", path.parent, mm_s_per_v)
        for line, row in enumerate(rows, start=2)
    )


def _point(
    row: dict[str, str], column: str, where: str, folder: Path, mm_s_per_v: float | None
) -> Point:
    values: dict[str, object] = {key: row.get(key) for key in DRIVE_COLUMNS}
    try:
        # Frequency comes first, because it is needed to convert the amplitude.
        drive = Point.model_validate({**values, "amplitude_um_pp": 0})
        reading = _Reading(
            text=row[column] or "",
            frequency_hz=drive.frequency_hz,
            folder=folder,
            mm_s_per_v=mm_s_per_v,
        )
        return Point.model_validate({**values, "amplitude_um_pp": QUANTITIES[column](reading)})
    except ValidationError as error:
        raise UserError("{where}: {faults}", where=where, faults=in_words(error)) from error
    except ValueError as error:
        raise UserError(
            "{where}: {column} is {error}", where=where, column=column, error=error
        ) from None
