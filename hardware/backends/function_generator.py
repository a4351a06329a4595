"""A function generator and an amplifier: carrier at resonance, amplitude by calibration.

SPEC: ``scpi:RESOURCE,option=value,...`` where RESOURCE is a VISA resource
(``USB0::0x0957::...::INSTR``) or a serial port (``/dev/ttyUSB0``), with

================  ===============================================================
``gain``          the amplifier's voltage gain; required, 1 without an amplifier,
                  unless a calibration or a plate file says it
``calibration``   a file written by ``slipscale plate calibrate``
``plate``         a file written by ``slipscale plate new``: limits, calibration,
                  gain and channel
``channel``       the generator's channel, 1 or 2 (1)
``dialect``       the make, see `generator_dialects` (by the answer to ``*IDN?``)
================  ===============================================================

**All volts in this file are V peak at the plate**, after the amplifier, but for what is sent to
the generator, which is V peak to peak at its own output.

The generator has **no watchdog**: when this computer dies the plate goes on vibrating. Use a
hardware interlock (docs/function-generator.md). It also has no readback of the vibration, so that
what is read back is the drive that is on.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from faults import UserError
from hardware import address as addresses
from hardware.backends.gain import agreed_gain
from hardware.backends.generator_dialects import (
    DIALECTS,
    KEYSIGHT,
    channel_number,
    dialect_named,
    dialect_of,
    is_on,
    number,
    words_of,
)
from hardware.clock import SystemClock
from hardware.driver import PlateDriver
from hardware.errors import (
    ConnectionLost,
    GarbledReply,
    PlateFault,
    PlateNotFound,
    PlateRefused,
    PlateTimeout,
    StillVibrating,
    WrongDevice,
)
from hardware.records import PlateIdentity, Presentation, Readback
from stimuli.modulation import along_edge

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hardware.backends.generator_dialects import Dialect, Item
    from hardware.calibration.record import Calibration
    from hardware.clock import Clock
    from hardware.limits import PlateLimits
    from hardware.plate_file import PlateFile

RAMP_S, RAMP_STEPS = 0.03, 10
SETTLING_TIME_CONSTANTS = 7  # to 0.1 %
UNKNOWN_PLATE_SETTLING_S = 0.05  # before there is a calibration to know Q from
SMALLEST_VPP = 0.01  # generators refuse less; 0 µm is output off
TIMEOUT_MS = 1_000
BAUD = 115_200  # where RESOURCE is a serial port
AGREEMENT = 1e-3  # of a setting that is read back
REOPENINGS, REOPENING_PAUSE_S = 3, 0.5  # after a drop, to switch the output off
VPP_PER_V_PEAK = 2.0

OPTIONS: dict[str, Callable[[str], Any]] = {
    "calibration": addresses.calibration,
    "plate": addresses.plate_file,
    "channel": channel_number,
    "dialect": dialect_named,
    "gain": addresses.positive_number,
}


class FunctionGenerator(PlateDriver):
    """A plate driven by a function generator.

    Parameters
    ----------
    resource : str
        VISA resource or serial port.
    clock : Clock
        Stamps the readbacks; the waits are the machine's.
    limits : PlateLimits
        At the plate.
    calibration : Calibration
        Needed to present surfaces; not to `excite`.
    plate_file : PlateFile
        Kept with the data; says the gain too.
    amplifier_gain : float
        Volts at the plate per volt of the generator; by default the calibration's.
    channel : int
        The generator's channel, 1 or 2.
    dialect : Dialect
        The generator's make; by default as it answers to ``*IDN?``.
    visa_library : str
        PyVISA's backend: ``@py`` needs no vendor's library.

    Raises
    ------
    UserError
        No gain is known, or two that differ.
    """

    name = "scpi"
    tracks = True

    def __init__(
        self,
        resource: str,
        *,
        clock: Clock,
        limits: PlateLimits | None = None,
        calibration: Calibration | None = None,
        plate_file: PlateFile | None = None,
        amplifier_gain: float | None = None,
        channel: int = 1,
        dialect: Dialect | None = None,
        visa_library: str = "@py",
    ) -> None:
        super().__init__(clock=clock, limits=limits, calibration=calibration, plate_file=plate_file)
        self.resource = resource if "::" in resource else f"ASRL{resource}::INSTR"
        wired = plate_file.wiring.amplifier_gain if plate_file else None
        self.amplifier_gain = agreed_gain(
            amplifier_gain,
            wired,
            calibration,
            unknown="plate 'scpi': the amplifier's gain is not known; say it in the SPEC as "
            "gain=20, or gain=1 without an amplifier",
        )
        self._vpp_per_v = VPP_PER_V_PEAK / self.amplifier_gain
        self._channel = channel
        self._chosen_dialect = dialect
        self._dialect = dialect or KEYSIGHT  # until it is known who answers
        self._visa_library = visa_library
        self._machine: Clock = SystemClock()
        self._instrument: Any = None
        self._voltage_v = 0.0
        self._may_be_on = False  # a generator was reached, and its output not confirmed off since
        self._out_of_reach = False  # and could not be switched off; that was told

    def _connect(self) -> PlateIdentity:
        self._close()
        self._open()
        fields = self._ask("*IDN?").split(",")
        if len(fields) != len(PlateIdentity.__slots__):
            raise WrongDevice(f"{self.resource}: '{','.join(fields)}' answers, no generator")
        found = self._chosen_dialect or dialect_of(fields[0], fields[1])
        if found is None:
            raise WrongDevice(
                f"{self.resource}: '{fields[0]} {fields[1]}' answers, a make that is not known; "
                f"dialect=... makes it one of: {', '.join(DIALECTS)}"
            )
        self._dialect = found
        self._may_be_on = True
        self._switch_off()
        self._write("*CLS")
        for each in found.fixed:
            self._write_item(each.item, each.value)
            value = self._ask_item(each.item)
            if not each.holds(value):
                raise PlateRefused(
                    f"{self.resource}: {self._command(each.item.ask)} is {value} after {each.value}"
                )
        self._no_errors()
        return PlateIdentity(
            manufacturer=fields[0], model=fields[1], serial=fields[2], firmware=fields[3]
        )

    def _open(self) -> None:
        # PyVISA takes a third of a second to import.
        from pymeasure.adapters import VISAAdapter  # noqa: PLC0415
        from pymeasure.instruments import Instrument, SCPIMixin  # noqa: PLC0415

        class Generator(SCPIMixin, Instrument):  # type: ignore[misc] # PyMeasure has no types
            """Any generator that speaks SCPI."""

        with self._told_as_faults(opening=True):
            adapter = VISAAdapter(
                self.resource,
                visa_library=self._visa_library,
                timeout=TIMEOUT_MS,
                open_timeout=TIMEOUT_MS,
                read_termination="\n",
                write_termination="\n",
                asrl={"baud_rate": BAUD},
            )
            self._instrument = Generator(adapter, "function generator")

    def _drive(self, amplitude_um_pp: float) -> Presentation:
        if self.calibration is None:
            raise UserError(
                "plate 'scpi': a function generator needs calibration=FILE; "
                "slipscale plate calibrate writes one"
            )
        begun_s = self._machine.now()
        resonance = self.calibration.resonance
        voltage_v = self.calibration.voltage_v_peak(amplitude_um_pp)
        self.limits.check_voltage(voltage_v)
        self._set(self._dialect.frequency_hz, self.tracked_hz or resonance.frequency_hz)
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
        self._set(self._dialect.frequency_hz, frequency_hz)
        self._ramp(voltage_v)
        self._machine.sleep(UNKNOWN_PLATE_SETTLING_S)
        return self._read_back()

    def _ramp(self, voltage_v: float) -> None:
        """Go to a voltage in small steps; below what the generator can do the output is off."""
        from_v = self._voltage_v
        if from_v == 0 and voltage_v > 0:
            self._set(self._dialect.voltage_vpp, SMALLEST_VPP)
            self._may_be_on = True
            self._write_item(self._dialect.output, self._dialect.on)
        if from_v != voltage_v:
            for step in range(1, RAMP_STEPS + 1):
                self._voltage_v = along_edge(from_v, voltage_v, step / RAMP_STEPS)
                vpp = max(self._voltage_v * self._vpp_per_v, SMALLEST_VPP)
                self._write_item(self._dialect.voltage_vpp, f"{vpp:.6f}")
                self._machine.sleep(RAMP_S / RAMP_STEPS)
        if voltage_v == 0:
            self._silence()
        else:
            vpp = max(voltage_v * self._vpp_per_v, SMALLEST_VPP)
            self._set(self._dialect.voltage_vpp, vpp)

    def _read_back(self) -> Readback:
        """Return the amplitude of the drive that is on, by the calibration."""
        voltage_v = 0.0
        if self._is_on():
            voltage_v = self._number(self._dialect.voltage_vpp) / self._vpp_per_v
        if self.calibration is None:
            return Readback(
                amplitude_um_pp=None,
                kind="none",
                time_s=self.clock.now(),
                voltage_v_peak=voltage_v,
            )
        return Readback(
            amplitude_um_pp=voltage_v * self.calibration.um_pp_per_v_peak,
            kind="applied",
            time_s=self.clock.now(),
            voltage_v_peak=voltage_v,
        )

    def _silence(self) -> None:
        if self._instrument is None and not self._may_be_on:
            return
        try:
            self._switch_off()
        except PlateFault as fault:
            if not self._may_be_on:
                raise
            self._reopen_and_switch_off(fault)

    def _switch_off(self) -> None:
        self._write_item(self._dialect.output, self._dialect.off)
        if self._is_on():
            raise PlateRefused(f"{self.resource}: the output is still on after it was switched off")
        self._voltage_v = 0.0
        self._may_be_on = self._out_of_reach = False

    def _reopen_and_switch_off(self, fault: PlateFault) -> None:
        """Open the line anew, at most so many times, until the output is off."""
        reopenings = 1 if self._out_of_reach else REOPENINGS
        for attempt in range(reopenings):
            if attempt:
                self._machine.sleep(REOPENING_PAUSE_S)
            try:
                self._release()
                self._open()
                self._switch_off()
            except PlateFault:
                continue
            return
        self._out_of_reach = True
        raise StillVibrating(
            f"{self.resource}: the output could not be switched off ({fault.message}; tried "
            f"{reopenings} times to open it anew), so the plate may still vibrate"
        ) from fault

    def _close(self) -> None:
        self._release()
        self._voltage_v = 0.0

    def _release(self) -> None:
        """Let go of the line."""
        instrument, self._instrument = self._instrument, None
        if instrument is not None:
            with self._told_as_faults():
                instrument.adapter.close()

    def _set(self, item: Item, value: float) -> None:
        """Set a value, read it back, and look whether the generator complains."""
        self._write_item(item, f"{value:.6f}")
        self._no_errors()
        answer = self._number(item)
        if not math.isclose(answer, value, rel_tol=AGREEMENT):
            raise PlateRefused(
                f"{self.resource}: {self._command(item.ask)} is {answer:g} after {value:g}"
            )

    def _no_errors(self) -> None:
        if self._dialect.error is None:
            return
        code, _, text = self._ask(self._dialect.error).partition(",")
        if code.strip("+ ") != "0":
            raise PlateRefused(f"{self.resource}: error {code}, {text}")

    def _is_on(self) -> bool:
        value = self._ask_item(self._dialect.output)
        on = is_on(value)
        if on is None:
            raise GarbledReply(
                f"{self.resource}: '{value}' answers {self._command(self._dialect.output.ask)}"
            )
        return on

    def _number(self, item: Item) -> float:
        text = self._ask_item(item)
        value = number(text)
        if math.isnan(value):
            raise GarbledReply(f"{self.resource}: '{text}' answers {self._command(item.ask)}")
        return value

    def _write_item(self, item: Item, value: str) -> None:
        self._write(self._command(item.write, value))

    def _ask_item(self, item: Item) -> str:
        query = self._command(item.ask)
        answer = self._ask(query)
        value = item.read(answer)
        if value is None:
            raise GarbledReply(f"{self.resource}: '{answer}' answers {query}")
        return value

    def _command(self, template: str, value: str = "") -> str:
        return template.format(value=value, **words_of(self._dialect, self._channel))

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
        No resource, an unknown option, no gain, or a calibration that cannot be used.
    """
    resource, options = addresses.split_address(address, OPTIONS)
    if not resource:
        raise UserError("plate 'scpi': expected scpi:RESOURCE, a VISA resource or a serial port")
    plate = addresses.plate_of(options, backend=FunctionGenerator.name)
    wired = plate.file.wiring.channel if plate.file else None
    channel = options.get("channel", wired or 1)
    if wired and channel != wired:
        raise UserError(
            f"plate 'scpi': channel is {channel}, but the plate file says {wired}: one of them "
            "drives another plate"
        )
    return FunctionGenerator(
        resource,
        clock=clock,
        limits=plate.limits,
        calibration=plate.calibration,
        plate_file=plate.file,
        amplifier_gain=options.get("gain"),
        channel=channel,
        dialect=options.get("dialect"),
    )
