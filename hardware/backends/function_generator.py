"""Drive a plate with a function generator and an amplifier, based on a calibration.

SPEC: ``scpi:RESOURCE,option=value,...`` where RESOURCE is a VISA resource
(``USB0::0x0957::...::INSTR``) or a serial port (``/dev/ttyUSB0``), with

================  ===============================================================
``gain``          the amplifier's voltage gain (1 without an amplifier); required
                  unless a calibration or a plate file defines it
``calibration``   a file written by ``slipscale plate calibrate``
``plate``         a file written by ``slipscale plate new``: limits, calibration,
                  gain and channel
``channel``       the generator's channel, 1 or 2 (1)
``attention``     seconds (5); if a session neither commands nor checks for this
                  long, it is assumed to hang and the output is switched off; 0: never
``dialect``       the make, see `generator_dialects` (default: from ``*IDN?``)
``frequency``     sine frequency, Hz: for a plate file in a quantity other than µm, in
                  place of a calibration
``per_volt``      the level per V peak at the plate, your own measurement at that
                  frequency; not for a plate in volts
================  ===============================================================

**All voltages in this file are V peak at the plate**, after the amplifier, except the values sent
to the generator, which are V peak to peak at the generator's output.

The generator has **no watchdog**. A guard process switches it off if the session is killed or
hangs. If the computer fails, the plate continues to vibrate: use a hardware interlock
(docs/how-to/function-generator.md). Because the generator does not measure vibration, the
readback is computed from the active drive.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.backends import drive_of_level
from slipscale.hardware.backends.gain import agreed_gain
from slipscale.hardware.backends.generator_dialects import Dialect, channel_number, dialect_named
from slipscale.hardware.backends.generator_line import Line, RelayedLine, instrument_of
from slipscale.hardware.backends.generator_output import GeneratorOutput
from slipscale.hardware.backends.guarded_generator import GuardedGenerator
from slipscale.hardware.clock import Clock, SystemClock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import OverLimit
from slipscale.hardware.output.unattended import Guarded
from slipscale.hardware.records import PlateIdentity, Presentation, Readback
from slipscale.stimuli.modulation import along_edge

if TYPE_CHECKING:
    from slipscale.hardware.backends.drive_of_level import DriveOfLevel

RAMP_S, RAMP_STEPS = 0.03, 10
VPP_PER_V_PEAK = 2.0

OPTIONS: dict[str, Callable[[str], object]] = {
    "attention": addresses.number_from_0,
    "channel": channel_number,
    "dialect": dialect_named,
    "gain": addresses.positive_number,
    **drive_of_level.OPTIONS,
}


class FunctionGenerator(PlateDriver):
    """Plate driven by a function generator.

    Parameters
    ----------
    line : Line
        Connection to the generator, not yet opened.
    clock : Clock
        Clock for the time stamps of readbacks.
    plate : Plate
        Limits at the plate, its calibration, which is required for surfaces but not for `excite`,
        and its file, which may define the gain.
    amplifier_gain : float
        Volts at the plate per volt of the generator; by default, the gain in the calibration.
    channel : int
        The generator's channel, 1 or 2.
    dialect : Dialect
        Commands for this make of generator; by default, the make is identified with ``*IDN?``.
    drive : DriveOfLevel
        Drive voltage per level, for plates whose levels are not in µm; by default, taken from the
        calibration.

    Raises
    ------
    UserError
        If the gain is unknown, or if two sources disagree about the gain.
    """

    name = "scpi"
    tracks = True

    def __init__(
        self,
        line: Line,
        *,
        clock: Clock,
        plate: addresses.Plate = addresses.DEFAULT_PLATE,
        amplifier_gain: float | None = None,
        channel: int = 1,
        dialect: Dialect | None = None,
        drive: DriveOfLevel | None = None,
    ) -> None:
        super().__init__(clock=clock, plate=plate)
        self._level_drive = drive or drive_of_level.calibrated(plate.calibration)
        self.limits = replace(self.limits, voltage_v=drive_of_level.largest_v_peak(self.limits))
        self._output = GeneratorOutput(line, channel, dialect)
        if isinstance(line, RelayedLine):
            line.relay = self._ask_guard
            held = partial(GuardedGenerator, line.resource, channel, dialect)
            self.unattended = Guarded(held)
            self.instrument = f"{instrument_of(line.resource)}, channel {channel}"
        self.amplifier_gain = agreed_gain(
            amplifier_gain,
            plate,
            unknown="plate 'scpi': the amplifier's gain is unknown; set it in the SPEC, for "
            "example "
            "gain=20 (gain=1 if there is no amplifier)",
        )
        self._vpp_per_v = VPP_PER_V_PEAK / self.amplifier_gain
        self._machine: Clock = SystemClock()
        self._voltage_v = self._frequency_hz = 0.0

    @property
    def resource(self) -> str:
        """Name of the VISA resource."""
        return self._output.line.resource

    def _connect(self) -> PlateIdentity:
        self._close()
        self._output.line.open()
        return self._output.prepare(self.limits.voltage_v * self._vpp_per_v)

    def _check_possible(self, level: float) -> None:
        if self._level_drive is not None:
            voltage_v = self._level_drive.voltage_v_peak(level)
            self.limits.check_voltage(voltage_v)
            self._check_range(voltage_v)

    def _check_range(self, voltage_v: float) -> None:
        """Raise `OverLimit` if the generator cannot produce the voltage; 0 V is always allowed."""
        made, vpp = self._output.range, voltage_v * self._vpp_per_v
        if made is None or voltage_v == 0 or made.smallest_vpp <= vpp <= made.largest_vpp:
            return
        raise OverLimit(
            "{voltage_v:.4g} V peak at the plate require {vpp:.4g} V peak to peak from the "
            "generator, which supplies {smallest_vpp:g} to {largest_vpp:g} V; use an amplifier "
            "with another gain, or other amplitudes",
            voltage_v=voltage_v,
            vpp=vpp,
            smallest_vpp=made.smallest_vpp,
            largest_vpp=made.largest_vpp,
        )

    def _drive(self, level: float) -> Presentation:
        drive = self._level_drive
        if drive is None:
            raise UserError(
                "plate 'scpi': a function generator needs calibration=FILE; "
                "slipscale plate calibrate writes one"
            )
        begun_s = self._machine.now()
        voltage_v = drive.voltage_v_peak(level)
        self._ramp(voltage_v, frequency_hz=self.tracked_hz or drive.frequency_hz)
        self._machine.sleep(drive.settling_s)
        return Presentation(
            commanded_level=level,
            readback=self._read_back(),
            settled_by="wait",
            settle_time_s=self._machine.now() - begun_s,
        )

    def _excite(self, *, frequency_hz: float, voltage_v: float) -> Readback:
        self._check_range(voltage_v)
        self._ramp(voltage_v, frequency_hz=frequency_hz)
        self._machine.sleep(drive_of_level.UNKNOWN_PLATE_SETTLING_S)
        return self._read_back()

    def _ramp(self, voltage_v: float, *, frequency_hz: float) -> None:
        """Ramp to a voltage in small steps; at 0 V, the output is switched off.

        Ramps start and end at the generator's smallest voltage. Each step is read back before the
        next command is sent, so that slow generators can keep up.
        """
        output, from_v = self._output, self._voltage_v
        output.verify()
        voltage, smallest_vpp = output.dialect.voltage_vpp, output.smallest_vpp
        output.set(output.dialect.frequency_hz, frequency_hz)
        self._frequency_hz = frequency_hz
        if from_v == 0 and voltage_v > 0:
            output.set(voltage, smallest_vpp)
            output.switch_on()
        if from_v != voltage_v:
            for step in range(1, RAMP_STEPS + 1):
                self._voltage_v = along_edge(from_v, voltage_v, step / RAMP_STEPS)
                output.write(voltage, f"{max(self._voltage_v * self._vpp_per_v, smallest_vpp):.6f}")
                output.number(voltage)
                self._machine.sleep(RAMP_S / RAMP_STEPS)
        if voltage_v == 0:
            self._silence()
        else:
            output.set(voltage, voltage_v * self._vpp_per_v)

    def _read_back(self) -> Readback:
        """Return the level that the active drive produces."""
        voltage_v = 0.0
        if self._output.is_on():
            self._output.verify()
            self._output.expect(self._output.dialect.frequency_hz, self._frequency_hz)
            voltage_v = self._output.number(self._output.dialect.voltage_vpp) / self._vpp_per_v
        if self._level_drive is None:
            return Readback(
                level=None,
                kind="none",
                time_s=self.clock.now(),
                voltage_v_peak=voltage_v,
            )
        return Readback(
            level=voltage_v * self._level_drive.level_per_v,
            kind="applied",
            time_s=self.clock.now(),
            voltage_v_peak=voltage_v,
        )

    def _silence(self) -> None:
        self._output.end(self._machine)
        self._voltage_v = 0.0

    def _close(self) -> None:
        self._output.line.release()
        self._voltage_v = 0.0


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:  # noqa: ARG001 - real
    """Return a driver for a function generator (entry point ``scpi``).

    Raises
    ------
    UserError
        If the resource or the gain is missing, an option is unknown, or the calibration is
        unusable.
    """
    resource, options, plate = addresses.opened(address, FunctionGenerator.name, OPTIONS)
    if not resource:
        raise UserError("plate 'scpi': expected scpi:RESOURCE, a VISA resource or a serial port")
    wired = plate.file.wiring.channel if plate.file else None
    channel = options.get("channel", wired or 1)
    if wired and channel != wired:
        raise UserError(
            "plate 'scpi': the SPEC has channel={channel}, but the plate file has channel "
            "{wired}; correct the wrong one",
            channel=channel,
            wired=wired,
        )
    plate_driver = FunctionGenerator(
        RelayedLine(resource),
        clock=clock,
        plate=plate,
        amplifier_gain=options.get("gain"),
        channel=channel,
        dialect=options.get("dialect"),
        drive=drive_of_level.stated(FunctionGenerator.name, options, plate),
    )
    plate_driver.attention_s = options.get("attention", plate_driver.attention_s)
    return plate_driver
