"""Read the state of a calibration from the output of the command that the console started."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

from slipscale.hardware.calibration.result import Result
from slipscale.hardware.calibration.sweep import COARSE_POINTS, FINE_POINTS, VOLTAGE_POINTS
from slipscale.hardware.cli.calibrate import ASKED, BACK

# Each sweep runs up and down: a coarse and a fine sweep in frequency, then one in voltage.
OF_FREQUENCY = 2 * (COARSE_POINTS + FINE_POINTS)
IN_ALL = OF_FREQUENCY + 2 * VOLTAGE_POINTS
BEGINS = (0, 2 * COARSE_POINTS, OF_FREQUENCY)  # readings before each sweep


class Measured(NamedTuple):
    """State of a calibration: the readings so far, and the point to be measured next.

    ``points`` contains (Hz, V, µm peak to peak) tuples. ``asked`` is the point to be measured next
    as (Hz, V), or None if no reading is expected. ``typed`` is true if a person types the readings.
    """

    points: tuple[tuple[float, float, float], ...]
    asked: tuple[float, float] | None
    typed: bool = False

    @property
    def may_go_back(self) -> bool:
        """Whether the previous point is part of the same sweep, so that it can be repeated."""
        return len(self.points) not in BEGINS


def measured_so_far(steps: Sequence[str]) -> Measured:
    """Return the readings reported by ``slipscale plate calibrate --steps``.

    >>> measured_so_far(["30000 5 ?", "30000 5 0.1", "30100 5 ?", "30100 5 b", "30000 5 ?"])
    Measured(points=(), asked=(30000.0, 5.0), typed=True)
    """
    found = Measured((), None)
    for step in steps:
        hz, volts, read = step.split()
        at = (float(hz), float(volts))
        if read == ASKED:
            found = found._replace(asked=at, typed=True)
        elif read == BACK:
            left = found.points[:-1] if found.may_go_back else found.points
            found = found._replace(points=left, asked=None)
        else:
            found = found._replace(points=(*found.points, (*at, float(read))), asked=None)
    return found


def result_in(said: str) -> Result | None:
    """Return the result that a calibration printed after its questions; None if there is none."""
    for line in said.splitlines()[-1:]:
        with suppress(ValueError):
            return Result.model_validate_json(line)
    return None
