"""The plate as a PsychoPy device, for experiments made with PsychoPy Builder or Coder.

This thin adapter uses the same driver, limits and watchdogs as a Slipscale session. After
`psychopy.plugins.activatePlugins()`, it is available as ``psychopy.hardware.SlipscalePlate``::

    from psychopy.hardware import DeviceManager
    plate = DeviceManager.addDevice(
        "slipscale.experiments.psychopy_plate.SlipscalePlate", "plate", spec="serial:/dev/ttyACM0"
    )
    plate.present(1.2)   # in the plate's unit, µm peak to peak; returns once it has settled
    ...                  # each frame: plate.check() raises a pending fault
    plate.silence()
"""

from __future__ import annotations

import atexit

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
        # PsychoPy does not close devices when a script ends.
        atexit.register(self.close)

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
        return self._plate.present(VirtualSurface(level=float(level)))

    def read_back(self) -> float | None:
        """Return the amplitude reported by the plate in µm peak to peak, or None."""
        return self._plate.read_back().level

    def check(self) -> None:
        """Raise `PlateFault` if the plate has failed; the check is fast enough for every frame."""
        self._plate.check()

    def silence(self) -> None:
        """Stop the vibration."""
        self._plate.silence()

    def close(self) -> None:
        """Stop the plate and close its connection."""
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
