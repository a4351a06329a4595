"""The plate as a PsychoPy device, for experiments built in PsychoPy's own Builder or Coder.

A thin adapter: what it presents goes through the same driver, limits and watchdogs as a Slipscale
session's. After `psychopy.plugins.activatePlugins()` it is ``psychopy.hardware.SlipscalePlate``::

    from psychopy.hardware import DeviceManager
    plate = DeviceManager.addDevice(
        "slipscale.experiments.psychopy_plate.SlipscalePlate", "plate", spec="serial:/dev/ttyACM0"
    )
    plate.present(1.2)   # µm peak to peak; returns once it has settled
    ...                  # each frame: plate.check() raises the fault that came up
    plate.silence()
"""

from __future__ import annotations

import atexit
from typing import TYPE_CHECKING, Any

from psychopy.hardware.base import BaseDevice
from serial.tools.list_ports import comports

from slipscale.hardware.address import without_session_watchdog
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

if TYPE_CHECKING:
    from slipscale.hardware.records import Presentation


class SlipscalePlate(BaseDevice):  # type: ignore[misc] # PsychoPy ships without types
    """A plate.

    Parameters
    ----------
    spec : str
        As after ``slipscale run --plate``: ``mock``, ``serial:PORT``, ``scpi:RESOURCE``, or a
        laboratory's own. A script need not call `check` in every frame: unless the SPEC says
        otherwise, the heartbeat of a serial board goes on for as long as the script lives.
    """

    def __init__(self, spec: str = "mock") -> None:
        self.spec = spec
        self._plate = open_plate(without_session_watchdog(spec), clock=SystemClock())
        self._plate.connect()
        # PsychoPy does not close devices when a script ends, or ends badly.
        atexit.register(self.close)

    def present(self, level: float) -> Presentation:
        """Ramp to an amplitude in µm peak to peak; return once it has settled.

        Raises
        ------
        UserError, PlateFault
            As `slipscale.hardware.driver.PlateDriver.present`; the plate is silent or as it was.
        """
        return self._plate.present(VirtualSurface(level=float(level)))

    def read_back(self) -> float | None:
        """Return the amplitude in µm peak to peak that the plate tells, or None."""
        return self._plate.read_back().level

    def check(self) -> None:
        """Raise the `PlateFault` that has come up, if any; cheap enough for every frame."""
        self._plate.check()

    def silence(self) -> None:
        """Stop the vibration."""
        self._plate.silence()

    def close(self) -> None:
        """Silence the plate and let go of it."""
        self._plate.close()
        atexit.unregister(self.close)

    def isSameDevice(self, other: object) -> bool:  # noqa: N802 - PsychoPy's name
        """Tell whether another device, or its parameters, means this plate."""
        spec = other.get("spec") if isinstance(other, dict) else getattr(other, "spec", None)
        return bool(spec == self.spec)

    @staticmethod
    def getAvailableDevices() -> list[dict[str, Any]]:  # noqa: N802 - PsychoPy's name
        """Return what could be opened: the mock, and each serial port."""
        specs = ["mock", *(f"serial:{port.device}" for port in sorted(comports()))]
        return [{"deviceName": f"plate {spec}", "spec": spec} for spec in specs]
