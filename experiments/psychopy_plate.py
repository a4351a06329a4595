"""The plate as a PsychoPy device, for experiments made with PsychoPy Builder or Coder.

This thin adapter uses the same driver, limits and watchdogs as a Slipscale session. After
`psychopy.plugins.activatePlugins()`, it is available as ``psychopy.hardware.SlipscalePlate``::

    from psychopy.hardware import DeviceManager
    plate = DeviceManager.addDevice(
        "slipscale.experiments.psychopy_plate.SlipscalePlate", "plate", spec="serial:/dev/ttyACM0"
    )
    with plate:
        plate.present(1.2)   # in the plate's unit, µm peak to peak; returns once it has settled
        ...                  # each frame: plate.check() raises a pending fault
        plate.begin(2.3)     # returns at once, so that frames are drawn until plate.settled
    # The plate is silent and closed here, also after an error.
"""

from __future__ import annotations

import atexit
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Self

from psychopy.hardware.base import BaseDevice
from serial.tools.list_ports import comports

from slipscale.faults.message import Message
from slipscale.hardware.address import without_session_watchdog
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.records import Presentation
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.surface import VirtualSurface


class SlipscalePlate(BaseDevice):  # type: ignore[misc] # PsychoPy ships without types
    """Plate device for PsychoPy scripts.

    Parameters
    ----------
    spec : str
        Plate as in ``slipscale run --plate``: ``mock``, ``serial:PORT``, ``scpi:RESOURCE`` or a
        laboratory's own backend. A script need not call `check` in every frame: by default, the
        heartbeat of a serial board continues as long as the script runs.
    """

    def __init__(self, spec: str = "mock") -> None:
        self.spec = spec
        self._plate = open_plate(without_session_watchdog(spec), clock=SystemClock())
        self._plate.connect()
        # One thread, so that the plate gets its commands one after the other.
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="plate")
        self._begun: Future[Presentation] | None = None
        # PsychoPy does not close devices when a script ends.
        atexit.register(self.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    @property
    def quantity(self) -> Quantity:
        """The physical quantity that the plate produces, with its unit."""
        return self._plate.limits.quantity

    def present(self, level: float) -> Presentation:
        """Ramp to an amplitude in µm peak to peak, and return when it has settled.

        Raises
        ------
        UserError, PlateFault
            See `slipscale.hardware.driver.PlateDriver.present`; after an error, the plate is silent
            or unchanged.
        """
        self._end()
        return self._plate.present(VirtualSurface(level=float(level)))

    def begin(self, level: float) -> None:
        """Start to ramp to an amplitude, as `present` does, and return at once.

        Draw frames until `settled` is True. A fault is raised by the next `check` or command.
        """
        self._end()
        self._begun = self._worker.submit(self._plate.present, VirtualSurface(level=float(level)))

    @property
    def settled(self) -> bool:
        """Whether the ramp that `begin` started is over; True if there was none."""
        return self._begun is None or self._begun.done()

    def _end(self) -> None:
        """Wait for the ramp that `begin` started, and raise its fault."""
        begun, self._begun = self._begun, None
        if begun is not None:
            begun.result()

    def read_back(self) -> float | None:
        """Return the amplitude reported by the plate in µm peak to peak, or None."""
        self._end()
        return self._plate.read_back().level

    def check(self) -> None:
        """Raise `PlateFault` if the plate has failed; the check is fast enough for every frame."""
        if self.settled:
            self._end()
            self._plate.check()

    def silence(self) -> None:
        """Stop the vibration, once a ramp that `begin` started is over."""
        try:
            self._end()
        finally:
            self._plate.silence()

    def close(self) -> None:
        """Stop the plate and close its connection."""
        self._worker.shutdown()
        self._plate.close()
        atexit.unregister(self.close)

    def isSameDevice(self, other: object) -> bool:  # noqa: N802 - PsychoPy's name
        """Return whether a device or a dictionary of device parameters has the same SPEC."""
        spec = other.get("spec") if isinstance(other, dict) else getattr(other, "spec", None)
        return bool(spec == self.spec)

    @staticmethod
    def getAvailableDevices() -> list[dict[str, object]]:  # noqa: N802 - PsychoPy's name
        """Return the available plates: the mock plate, and one plate per serial port."""
        specs = ["mock", *(f"serial:{port.device}" for port in sorted(comports()))]
        return [{"deviceName": Message("plate {spec}", spec=spec), "spec": spec} for spec in specs]
