"""Drive two actuators on one plate, such as ultrasonic vibration and electrovibration.

The SPEC is ``pair:FIRST+SECOND``, where FIRST and SECOND are SPECs of backends. A session treats
the first actuator as the plate: surfaces, readback and limits refer to it. The second actuator
holds `PlateDriver.second_level` during every surface, in its own quantity and within its own
limits.

Both actuators are complete drivers, each with its own limits, watchdog and guard. A fault in either
actuator switches off both, and *confirmed off* requires both to confirm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware import registry
from slipscale.hardware.address import SPLIT, Plate, parts
from slipscale.hardware.clock import Clock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import ConnectionLost, StillVibrating
from slipscale.hardware.output.unattended import StopsAlone
from slipscale.hardware.records import Output, PlateIdentity, Presentation, Readback
from slipscale.stimuli.modulation import Loop
from slipscale.stimuli.surface import Sensor, Surface, VirtualSurface


class PlatePair(PlateDriver):
    """Pair of drivers that are commanded, checked and switched off together.

    Parameters
    ----------
    first, second : PlateDriver
        Drivers that share a clock and are not yet connected.
    """

    name = "pair"
    frozen_s = math.inf  # Each actuator detects it.
    unattended = StopsAlone("each actuator has its own declaration")

    def __init__(self, first: PlateDriver, second: PlateDriver) -> None:
        super().__init__(clock=first.clock, plate=Plate(limits=first.limits, file=first.plate_file))
        self.first, self.second = first, second
        self.calibration = first.calibration
        self._follow_the_first()

    def _follow_the_first(self) -> None:
        first = self.first
        self.limits = first.limits
        self.modulator, self.follow_lag_s = first.modulator, first.follow_lag_s
        self.why_not_modulated, self.amplifier_gain = first.why_not_modulated, first.amplifier_gain

    @property
    def unfelt(self) -> bool:
        """Whether at least one actuator is simulated, so that a finger cannot feel it."""
        return self.first.unfelt or self.second.unfelt

    def check_supported(self, surface: Surface, *, sensors: Collection[Sensor] = ()) -> Loop | None:
        """Check the second actuator's level, and return the first actuator's loop for a surface."""
        self.second.check_supported(VirtualSurface(level=self.second_level))
        return self.first.check_supported(surface, sensors=sensors)

    def confirm(self, commanded_level: float, readback: Readback) -> None:
        """Check a readback of the first actuator. Raises `NotReached` or `OffCalibration`."""
        self.first.confirm(commanded_level, readback)

    def vibration_level(self) -> float:
        """Return the current level of the first actuator."""
        return self.first.vibration_level()

    def describe(self) -> dict[str, object]:
        """Return the first actuator's session record, which includes that of the second."""
        second = self.second.describe()
        named = self.second.limits.quantity.named
        limits = {named(name): value for name, value in second["limits"].items()}
        return {**self.first.describe(), "second": {**second, "limits": limits}}

    def _connect(self) -> PlateIdentity:
        first = self.first.connect()
        self.second.connect()
        self._follow_the_first()
        return first

    def _check_identity(self, _identity: PlateIdentity) -> tuple[str, ...]:
        return (
            *self.first.notes,
            *(Message("second actuator: {fault}", fault=each) for each in self.second.notes),
        )

    def _vibrates(self, level: float) -> bool:
        return level > 0 or self.second_level > 0

    def _drive(self, level: float) -> Presentation:
        second = self.second.present(VirtualSurface(level=self.second_level))
        self.first.attend()  # Commands to a slow instrument can take seconds.
        made = self.first.present(VirtualSurface(level=level))
        self.second.attend()
        return replace(made, second_readback_level=second.readback.level)

    def _read_back(self) -> Readback:
        self.second.confirm(self.second_level, self.second.read_back())
        return self.first.read_back()

    def _check(self) -> None:
        self.first.check()
        self.second.check()

    def _play(self, loop: Loop) -> None:
        # The first actuator has settled; presenting again would also drive the second again.
        self.first._play(loop)  # noqa: SLF001
        self.first._played = loop  # noqa: SLF001

    def _change(self, change: Loop) -> None:
        self.first.play(change)

    def _follow(self, level: float) -> None:
        self.first.follow(level)

    def _silence(self) -> None:
        self._both(lambda plate: plate.silence())
        # Drivers do not report a fault twice.
        for plate in (self.first, self.second):
            if self._opened and plate.output is not Output.OFF:
                raise ConnectionLost(
                    "plate '{plate_name}' did not confirm that it is off", plate_name=plate.name
                )

    def _close(self) -> None:
        self._both(lambda plate: plate.close())

    def _both(self, action: Callable[[PlateDriver], None]) -> None:
        """Perform an action on both actuators, even if one fails.

        If both fail, the more serious error is raised: a signal, `StillVibrating`, any other error.
        """
        raised: list[BaseException] = []
        for plate in (self.first, self.second):
            try:
                action(plate)
            except BaseException as error:  # noqa: BLE001 - a signal must not leave the second on
                raised.append(error)
        if raised:
            raise max(raised, key=_severity)


def _severity(error: BaseException) -> int:
    return 2 if not isinstance(error, Exception) else isinstance(error, StillVibrating)


def pair_of(spec: str) -> tuple[str, str]:
    """Split the SPEC of a pair into the SPECs of both actuators.

    Raises
    ------
    UserError
        If the SPEC does not consist of two SPECs separated by ``+``.
    """
    specs = parts(spec)
    if len(specs) != 2 or not all(specs):  # noqa: PLR2004 - a pair
        raise UserError(
            "plate '{spec}': expected two SPECs separated by {separator}, such as "
            "pair:serial:PORT{separator}daq:CHANNEL",
            spec=spec,
            separator=SPLIT,
        )
    return specs[0], specs[1]


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:
    """Return a driver for two actuators (entry point ``pair``). Raises `UserError`."""
    specs = pair_of(f"{PlatePair.name}:{address}")
    first, second = (registry.open_plate(spec, clock=clock, seed=seed) for spec in specs)
    return PlatePair(first, second)
