"""Track the resonance between trials, for plates that do not track it themselves.

The resonance is swept before the surface of a trial is presented, never while a surface is felt or
rated. Standards that are presented outside trials are not preceded by a sweep. Like a failed
presentation, a failed sweep is a rig fault.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from statistics import fmean
from typing import TYPE_CHECKING

from slipscale.hardware.contact.source import ContactSource, SensorFault
from slipscale.hardware.resonance_tracking import track

if TYPE_CHECKING:
    from slipscale.experiments.journal.journal import Journal
    from slipscale.experiments.steps.steps import Present
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.driver import PlateDriver

READ_S = 0.1  # averaging time for an amplitude


class ResonanceTracking:
    """Tracks the plate's resonance with sweeps of three frequencies before trials.

    Parameters
    ----------
    plate : PlateDriver
    vibrometer : ContactSource
        A connected source that measures the plate's amplitude in µm peak to peak.
    every_s : float
        Minimum time between two sweeps.
    """

    def __init__(self, plate: PlateDriver, vibrometer: ContactSource, every_s: float) -> None:
        self._plate = plate
        self._vibrometer = vibrometer
        self._every_s = every_s
        self._last_s = -math.inf

    def before(self, step: Present, journal: Journal, clock: Clock) -> None:
        """Run a sweep if necessary, and record the result.

        Raises
        ------
        PlateFault
            If the rig or the vibrometer failed; the plate is then silent.
        """
        if step.trial is None or clock.now() - self._last_s < self._every_s:
            return

        def measured_level() -> float:
            self._vibrometer.begin()
            clock.sleep(READ_S)
            samples = self._vibrometer.take()
            if not samples:
                raise SensorFault("the vibrometer returned no readings in the sweep")
            return fmean(each.values[0] for each in samples)

        found = track(self._plate, measured_level)
        self._last_s = clock.now()
        journal.append("tracking", trial=step.trial.number, **asdict(found))
