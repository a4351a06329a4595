"""A function generator and an amplifier: carrier at resonance, amplitude by calibration.

SPEC: ``scpi:RESOURCE,calibration=FILE,gain=G`` where RESOURCE is a VISA resource
(``USB0::0x0957::...::INSTR``) or a serial port (``/dev/ttyUSB0``), and ``gain`` the amplifier's
voltage gain (the calibration's by default). The commands are those that Agilent's, Keysight's and
Rigol's generators share.

The generator has **no watchdog**: when this computer dies the plate goes on vibrating. Use a
hardware interlock (docs/function-generator.md). It also has no readback of the vibration, so that
what is read back is the drive that is on.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

from faults import UserError
from hardware import address as addresses
from hardware.clock import SystemClock
from hardware.driver import PlateDriver
from hardware.errors import (
    ConnectionLost,
    GarbledReply,
    PlateNotFound,
    PlateRefused,
    PlateTimeout,
    WrongDevice,
)
from hardware.records import PlateIdentity, Presentation, Readback
from stimuli.modulation import along_edge

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hardware.calibration.record import Calibration
    from hardware.clock import Clock
    from hardware.limits import PlateLimits

RAMP_S, RAMP_STEPS = 0.03, 10
SETTLING_TIME_CONSTANTS = 7  # to 0.1 %
UNKNOWN_PLATE_SETTLING_S = 0.05  # before there is a calibration to know Q from
SMALLEST_VPP = 0.01  # generators refuse less; 0 µm is output off
TIMEOUT_MS = 1_000
BAUD = 115_200  # where RESOURCE is a serial port
AGREEMENT = 1e-3  # of a setting that is read back

VPP_OF = {"V peak": 2.0, "V peak-to-peak": 1.0, "V RMS": 2 * math.sqrt(2)}

OPTIONS: dict[str, Callable[[str], Any]] = {
    "calibration": addresses.calibration,
    "gain": addresses.number,
}


class Setting(NamedTuple):
    """A command that is set once on connecting, and what reading it back must begin with."""

    header: str
    value: str
    reads: str


# The load matters: a generator that believes in 50 Ω puts twice its volts on an open circuit.
SETTINGS = (
    Setting("FUNC", "SIN", "SIN"),
    Setting("OUTP:LOAD", "INF", "9.9"),
    Setting("VOLT:UNIT", "VPP", "VPP"),
    Setting("VOLT:OFFS", "0", "+0"),
)


class FunctionGenerator(PlateDriver):
    """A plate driven by a function generator.

    Parameters
    ----------
    resource : str
        VISA resource or serial port.
    clock : Clock
        Stamps the readbacks; the waits are the machine's.
    limits : PlateLimits
        In the calibration's voltage convention, at the plate.
    calibration : Calibration
        Needed to present surfaces; not to `excite`.
    amplifier_gain : float
        Volts at the plate per volt of the generator.
    visa_library : str
        PyVISA's backend: ``@py`` needs no vendor's library.
    """

    name = "scpi"

    def __init__(
        self,
        resource: str,
        *,
        clock: Clock,
        limits: PlateLimits | None = None,
        calibration: Calibration | None = None,
        amplifier_gain: float | None = None,
        visa_library: str = "@py",
    ) -> None:
        super().__init__(clock=clock, limits=limits, calibration=calibration)
        self.resource = resource if "::" in resource else f"ASRL{resource}::INSTR"
        calibrated_gain = calibration.drive.amplifier_gain if calibration else None
        gain = amplifier_gain or calibrated_gain or 1.0
        if calibrated_gain is not None and not math.isclose(gain, calibrated_gain):
            raise UserError(
                f"plate 'scpi': gain is {gain:g}, but the calibration was made with "
                f"{calibrated_gain:g}"
            )
        convention = calibration.drive.voltage_convention if calibration else "V peak"
        self._vpp_per_v = VPP_OF[convention] / gain
        self._visa_library = visa_library
        self._machine = SystemClock()
        self._instrument: Any = None
        self._voltage_v = 0.0

    def _connect(self) -> PlateIdentity:
        # PyVISA takes a third of a second to import.
        from pymeasure.adapters import VISAAdapter  # noqa: PLC0415
        from pymeasure.instruments import Instrument, SCPIMixin  # noqa: PLC0415

        class Generator(SCPIMixin, Instrument):  # type: ignore[misc] # PyMeasure has no types
            """Any generator that speaks SCPI."""

        self._close()
        with self._told_as_faults(opening=True):
            adapter = VISAAdapter(
                self.resource,
                visa_library=self._visa_library,
                timeout=TIMEOUT_MS,
                read_termination="\n",
                write_termination="\n",
                asrl={"baud_rate": BAUD},
            )
            self._instrument = Generator(adapter, "function generator")
        self._write("OUTP 0")
        fields = self._ask("*IDN?").split(",")
        if len(fields) != len(PlateIdentity.__slots__):
            raise WrongDevice(f"{self.resource}: '{','.join(fields)}' answers, no generator")
        self._write("*CLS")
        for each in SETTINGS:
            self._write(f"{each.header} {each.value}")
            answer = self._ask(f"{each.header}?")
            if not answer.startswith(each.reads):
                raise PlateRefused(f"{self.resource}: {each.header} is {answer} after {each.value}")
        self._no_errors()
        return PlateIdentity(
            manufacturer=fields[0], model=fields[1], serial=fields[2], firmware=fields[3]
        )

    def _drive(self, amplitude_um_pp: float) -> Presentation:
        if self.calibration is None:
            raise UserError(
                "plate 'scpi': a function generator needs calibration=FILE; "
                "slipscale plate calibrate writes one"
            )
        begun_s = self._machine.now()
        resonance = self.calibration.resonance
        voltage_v = self.calibration.voltage_v(amplitude_um_pp)
        self.limits.check_voltage(voltage_v)
        self._set("FREQ", resonance.frequency_hz)
        self._ramp(voltage_v)
        time_constant_s = resonance.quality_factor / (math.pi * resonance.frequency_hz)
        self._machine.sleep(SETTLING_TIME_CONSTANTS * time_constant_s)
        return Presentation(
            commanded_um_pp=amplitude_um_pp,
            readback=self._read_back(),
            settled_by="wait",
            settle_time_s=self._machine.now() - begun_s,
        )

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        self._set("FREQ", frequency_hz)
        self._ramp(voltage_v)
        self._machine.sleep(UNKNOWN_PLATE_SETTLING_S)
        return self._read_back()

    def _ramp(self, voltage_v: float) -> None:
        """Go to a voltage in small steps; below what the generator can do the output is off."""
        from_v = self._voltage_v
        if from_v == 0 and voltage_v > 0:
            self._set("VOLT", SMALLEST_VPP)
            self._write("OUTP 1")
        if from_v != voltage_v:
            for step in range(1, RAMP_STEPS + 1):
                self._voltage_v = along_edge(from_v, voltage_v, step / RAMP_STEPS)
                vpp = max(self._voltage_v * self._vpp_per_v, SMALLEST_VPP)
                self._write(f"VOLT {vpp:.6f}")
                self._machine.sleep(RAMP_S / RAMP_STEPS)
        if voltage_v == 0:
            self._silence()
        else:
            self._set("VOLT", max(voltage_v * self._vpp_per_v, SMALLEST_VPP))

    def _read_back(self) -> Readback:
        """Return the amplitude of the drive that is on, by the calibration."""
        on = self._number("OUTP?") != 0
        voltage_v = self._number("VOLT?") / self._vpp_per_v if on else 0.0
        if self.calibration is None:
            return Readback(amplitude_um_pp=None, kind="none", time_s=self.clock.now())
        return Readback(
            amplitude_um_pp=voltage_v * self.calibration.gain.um_pp_per_v,
            kind="applied",
            time_s=self.clock.now(),
        )

    def _silence(self) -> None:
        if self._instrument is not None:
            self._write("OUTP 0")
            if self._number("OUTP?") != 0:
                raise PlateRefused(f"{self.resource}: the output is still on after OUTP 0")
            self._voltage_v = 0.0

    def _close(self) -> None:
        if self._instrument is not None:
            with self._told_as_faults():
                self._instrument.adapter.close()
        self._instrument = None
        self._voltage_v = 0.0

    def _set(self, header: str, value: float) -> None:
        """Set a value, read it back, and look whether the generator complains."""
        self._write(f"{header} {value:.6f}")
        self._no_errors()
        answer = self._number(f"{header}?")
        if not math.isclose(answer, value, rel_tol=AGREEMENT):
            raise PlateRefused(f"{self.resource}: {header} is {answer:g} after {value:g}")

    def _no_errors(self) -> None:
        code, _, text = self._ask("SYST:ERR?").partition(",")
        if code.strip("+ ") != "0":
            raise PlateRefused(f"{self.resource}: error {code}, {text}")

    def _number(self, query: str) -> float:
        answer = self._ask(query)
        try:
            return float(answer)
        except ValueError as error:
            raise GarbledReply(f"{self.resource}: '{answer}' answers {query}") from error

    def _write(self, command: str) -> None:
        with self._told_as_faults():
            self._require_instrument().write(command)

    def _ask(self, query: str) -> str:
        with self._told_as_faults():
            return str(self._require_instrument().ask(query)).strip()

    def _require_instrument(self) -> Any:
        if self._instrument is None:
            raise ConnectionLost(f"{self.resource}: not connected")
        return self._instrument

    @contextmanager
    def _told_as_faults(self, *, opening: bool = False) -> Iterator[None]:
        from pyvisa.constants import StatusCode  # noqa: PLC0415 - loaded by now, or never needed
        from pyvisa.errors import VisaIOError  # noqa: PLC0415

        try:
            yield
        except (VisaIOError, OSError, ValueError) as error:
            if opening:
                raise PlateNotFound(f"{self.resource}: cannot be opened ({error})") from error
            if getattr(error, "error_code", None) == StatusCode.error_timeout:
                raise PlateTimeout(f"{self.resource}: no answer") from error
            raise ConnectionLost(f"{self.resource}: the device went away ({error})") from error


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:  # noqa: ARG001 - real
    """Return a driver for a function generator: the entry point ``scpi``.

    Raises
    ------
    UserError
        No resource, an unknown option, or a calibration that cannot be used.
    """
    resource, options = addresses.split_address(address, OPTIONS)
    if not resource:
        raise UserError("plate 'scpi': expected scpi:RESOURCE, a VISA resource or a serial port")
    return FunctionGenerator(
        resource,
        clock=clock,
        calibration=options.get("calibration"),
        amplifier_gain=options.get("gain"),
    )
