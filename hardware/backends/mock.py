"""Provide the mock plate, a simulated plate for pilots and tests.

SPEC: ``mock`` or ``mock:option=value,...`` with

==============  ==================================================================
``q``           quality factor (60)
``finger``      loss that a finger adds to 1/Q (0); 0.0033 reduces Q from 60 to 50
``noise``       standard deviation of a vibrometer reading, µm (0.005)
``calibration`` a file written by ``slipscale plate calibrate``: narrows the limits
``plate``       a file written by ``slipscale plate new``: limits and calibration
``guard``       a file to which a guard process writes when it switches the plate off
``fault``       faults to inject: ``CODE@PHASE/N``, see
                `slipscale.hardware.backends.fault_injection`. CODE is a `PlateFault.code`; PHASE
                is connect, present, read_back, silence or check. ``CODE@N`` counts commands of
                all phases except check (called every frame)
==============  ==================================================================

For quantities other than µm peak to peak, only the dynamics are simulated: the simulation's largest
amplitude corresponds to the plate's largest level, and no drive voltage is reported.

A fault ``lost`` lasts until the next connect; all other faults last for one command. As on a real
board, the plate is silenced when the connection is lost.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from slipscale.faults.message import Message
from slipscale.hardware import address as addresses
from slipscale.hardware.backends.fault_injection import Injection, Schedule, parse_injections
from slipscale.hardware.backends.guard_recorder import GuardRecorder
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import FAULTS, ConnectionLost
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.output.unattended import Guarded, StopsAlone, Unattended
from slipscale.hardware.plate.dynamics import FingerLoad, Resonator
from slipscale.hardware.plate.twin import OFF, SETTLING_TIME_CONSTANTS, Drive, Twin
from slipscale.hardware.records import PlateIdentity, Presentation, Readback
from slipscale.stimuli.modulation import Loop, Modulator, along_edge

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.stimuli.quantity import Quantity

RAMP_S = 0.025  # raised cosine, to avoid a click
RAMP_STEPS = 16
VOLTAGE_DIGITS, TEMPERATURE_DIGITS = 3, 1  # number of decimals that a driver board reports

PHASES = ("connect", "present", "read_back", "silence", "check")
OPTIONS: dict[str, Callable[[str], object]] = {
    "q": addresses.number,
    "finger": addresses.number,
    "noise": addresses.number_from_0,
    "guard": str,
    "fault": partial(parse_injections, faults=FAULTS, phases=PHASES),
}


@dataclass(frozen=True, slots=True)
class Command:
    """Command received by the mock plate, recorded for tests."""

    time_s: float
    name: str
    amplitude_um_pp: float | None = None


class MockPlate(PlateDriver):
    """Plate whose dynamics are simulated.

    Parameters
    ----------
    clock : Clock
        Clock for ramps and settling; with a virtual clock, nothing waits.
    twin : Twin
        Simulated dynamics of the plate.
    plate : Plate
        Limits, calibration and file of the plate.
    injections : iterable of Injection
        Faults to inject.
    """

    name = "mock"
    simulated = True
    frozen_s = math.inf  # Simulated people do not check the plate while they explore it.
    unattended: Unattended = StopsAlone("the plate is simulated by this process")

    def __init__(
        self,
        *,
        clock: Clock,
        twin: Twin | None = None,
        plate: addresses.Plate = addresses.DEFAULT_PLATE,
        injections: Iterable[Injection] = (),
    ) -> None:
        super().__init__(clock=clock, plate=plate)
        self.twin = twin or Twin(voltage_limit_v=self.limits.voltage_v)
        resonator = self.twin.resonator
        self.modulator = Modulator(
            resonance_hz=resonator.resonance_hz, quality_factor=resonator.quality_factor
        )
        # The drive is ideal, so only the plate's ring-up time limits modulation.
        self.follow_lag_s = resonator.quality_factor / (math.pi * resonator.resonance_hz)
        self.log: list[Command] = []
        self._schedule = Schedule(injections)
        self._connected = False
        self._lost = False  # The connection is lost, and the board has silenced the plate.

    def inject(self, fault: str, *, phase: str = "", n: int = 1) -> None:
        """Inject a fault at the ``n``-th command of a phase, counted from now.

        If ``phase`` is empty, commands of all phases except "check" are counted.
        """
        if fault not in FAULTS or phase not in ("", *PHASES):
            raise ValueError(
                Message(
                    "unknown fault '{fault}' or unknown phase '{phase}'", fault=fault, phase=phase
                )
            )
        self._schedule.add(Injection(fault, phase, n))

    def adopt(self, quantity: Quantity, largest_level: float) -> None:
        """Adopt the study's quantity and largest level if the plate produces another quantity."""
        if quantity.makes != self.limits.quantity.makes:
            self.largest_level = largest_level
            deviation_level = self.limits.deviation_level * largest_level / self.limits.level
            self.limits = replace(
                self.limits,
                quantity=quantity,
                level=largest_level,
                deviation_level=deviation_level,
            )

    @property
    def _um_per_level(self) -> float:
        limits = self.limits
        return 1.0 if limits.quantity.in_um_pp else PlateLimits().level / limits.level

    def vibration_level(self) -> float:
        """Return the true simulated level, even if the connection is lost."""
        return self.twin.amplitude_um_pp(self.clock.now()) / self._um_per_level

    def _connect(self) -> PlateIdentity:
        self._note_command("connect")
        self._connected, self._lost = True, False
        self._set(OFF)
        return PlateIdentity(
            manufacturer="Slipscale", model="mock plate", serial="twin", firmware="1"
        )

    def _drive(self, level: float) -> Presentation:
        self._note_command("present", level)
        amplitude_um_pp = level * self._um_per_level
        begun_s = self.clock.now()
        from_um_pp = self.twin.drive.target_um_pp or 0.0
        frequency_hz = self.twin.resonator.resonance_hz
        for step in range(1, RAMP_STEPS + 1):
            target_um_pp = along_edge(from_um_pp, amplitude_um_pp, step / RAMP_STEPS)
            self._set(Drive(frequency_hz=frequency_hz, target_um_pp=target_um_pp))
            self.clock.sleep(RAMP_S / RAMP_STEPS)
        self._set(Drive(frequency_hz=frequency_hz, target_um_pp=amplitude_um_pp))
        self._settle()
        readback = self._measure()
        return Presentation(
            commanded_level=level,
            readback=readback,
            settled_by="readback",
            settle_time_s=readback.time_s - begun_s,
        )

    def _play(self, loop: Loop) -> None:
        self._set(self._playing(loop))
        self._settle()

    def _change(self, change: Loop) -> None:
        self._require_line()
        self._set(replace(self._playing(change), since_s=self.clock.now()))

    def _playing(self, loop: Loop) -> Drive:
        frequency_hz, scale = self.twin.resonator.resonance_hz, self._um_per_level
        levels = tuple(level * scale for level in loop.levels)
        played = replace(loop, levels=levels, mean_level=loop.mean_level * scale)
        return Drive(frequency_hz=frequency_hz, target_um_pp=played.mean_level, played=played)

    def _follow(self, level: float) -> None:
        self._require_line()
        frequency_hz = self.twin.resonator.resonance_hz
        self._set(Drive(frequency_hz=frequency_hz, target_um_pp=level * self._um_per_level))

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        self._note_command("present")
        self._set(Drive(frequency_hz=frequency_hz, voltage_v=voltage_v))
        self._settle()
        return self._measure()

    def _read_back(self) -> Readback:
        self._note_command("read_back")
        return self._measure()

    def _silence(self) -> None:
        if self._lost:
            raise ConnectionLost("mock plate: the connection was lost")
        if self._connected:
            self._note_command("silence")
            self._set(OFF)

    def _check(self) -> None:
        self._raise_ordered(self._schedule.due("check", everywhere=False))
        self._require_line()

    def _close(self) -> None:
        self._connected = self._lost = False

    def _note_command(self, name: str, amplitude_um_pp: float | None = None) -> None:
        self.log.append(Command(self.clock.now(), name, amplitude_um_pp))
        self._raise_ordered(self._schedule.due(name))
        if name != "connect":
            self._require_line()

    def _raise_ordered(self, faults: list[str]) -> None:
        for code in faults:
            if code == ConnectionLost.code:
                self._set(OFF)
                self._connected, self._lost = False, True
            raise FAULTS[code](Message("mock plate: fault '{code}', as requested", code=code))

    def _require_line(self) -> None:
        if not self._connected:
            raise ConnectionLost("mock plate: not connected")

    def _set(self, drive: Drive) -> None:
        self.twin.set_drive(drive, self.clock.now())

    def _settle(self) -> None:
        time_constant_s = self.twin.conditions(self.clock.now()).time_constant_s
        self.clock.sleep(SETTLING_TIME_CONSTANTS * time_constant_s)

    def _measure(self) -> Readback:
        now_s = self.clock.now()
        voltage_v = round(self.twin.voltage_v(now_s), VOLTAGE_DIGITS)
        return Readback(
            level=self.twin.measure_um_pp(now_s) / self._um_per_level,
            kind="measured",
            time_s=now_s,
            voltage_v_peak=voltage_v if self.limits.quantity.in_um_pp else None,
            temperature_c=round(self.twin.temperature_c(now_s), TEMPERATURE_DIGITS),
        )


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:
    """Return a driver for a mock plate (entry point ``mock``).

    Raises
    ------
    UserError
        If the address contains an unknown option.
    """
    _, options, plate = addresses.opened(address, MockPlate.name, OPTIONS, simulated=True)
    twin = Twin(
        seed=seed,
        resonator=Resonator(quality_factor=options.get("q", Resonator().quality_factor)),
        finger=FingerLoad(loss=options.get("finger", 0.0)),
        voltage_limit_v=plate.limits.voltage_v,
        **({"noise_um": options["noise"]} if "noise" in options else {}),
    )
    made = MockPlate(
        clock=clock,
        twin=twin,
        plate=plate,
        injections=options.get("fault", ()),
    )
    if "guard" in options:
        made.unattended = Guarded(partial(GuardRecorder, options["guard"]))
    return made
