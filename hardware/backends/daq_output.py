"""Drive an actuator with a sine wave from a National Instruments analogue output.

Use this backend for an electrovibration screen behind an amplifier (level in volts) or for a
vibrotactile actuator below 1 kHz (level as acceleration or displacement). SPEC:
``daq:Dev1/ao0,plate=desk,...`` with

==============  ==================================================================
``plate``       the plate file: quantity and limits; required
``frequency``   sine frequency, Hz; required
``per_volt``    the level per volt (peak) at the terminal: amplifier and actuator; required
``readback``    a voltage input that is wired to the output, such as Dev1/ai0
``rate``        samples per second (100 per period)
``attention``   seconds (5); if a session neither commands nor checks for this long, it is
                assumed to hang and the output is switched off; 0: never
==============  ==================================================================

The user must measure ``per_volt`` at the given frequency. If ``readback`` is given, the reported
level is computed from the voltage measured at that input (readback "applied"). Otherwise, the
commanded level is reported (readback "commanded"). The channel ``emulated/ao0`` selects an emulated
device.

**This backend has not been tested on a real device.** A guard process switches the output off if
the session is killed or hangs. If the computer fails, the device keeps playing until an interlock
at the amplifier switches it off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.backends import daq_device
from slipscale.hardware.backends.daq_library import TERMINAL_V, hold_at_zero, load_library
from slipscale.hardware.backends.guarded_daq import GuardedDaq
from slipscale.hardware.clock import Clock
from slipscale.hardware.driver import PlateDriver
from slipscale.hardware.errors import ConnectionLost, OverLimit, StillVibrating
from slipscale.hardware.output.unattended import Guarded, StopsAlone
from slipscale.hardware.records import EMULATED, PlateIdentity, Presentation, Readback
from slipscale.stimuli.modulation import along_edge

RAMP_S, RAMP_STEPS = 0.05, 16  # raised cosine
PERIODS = 10  # periods in the repeated buffer
SAMPLES_PER_PERIOD = 100
EMULATED_DEVICE = "emulated/"


def _channel(text: str) -> str:
    if "/" not in text:
        raise ValueError("expected a channel such as Dev1/ai0")
    return text


OPTIONS: dict[str, Callable[[str], Any]] = {
    "attention": addresses.number_from_0,
    "frequency": addresses.positive_number,
    "per_volt": addresses.positive_number,
    "rate": addresses.positive_number,
    "readback": _channel,
}


class DaqOutput(PlateDriver):
    """Actuator driven by a sine wave of constant frequency.

    Parameters
    ----------
    channel : str
        Name of the analogue output.
    options : dict
        See the module's documentation.
    clock, plate
        See `slipscale.hardware.driver.PlateDriver`.

    Raises
    ------
    UserError
        If the frequency is outside the plate's band or too high for the sampling rate.
    """

    name = "daq"

    def __init__(
        self, channel: str, options: dict[str, Any], *, clock: Clock, plate: addresses.Plate
    ) -> None:
        super().__init__(clock=clock, plate=plate)
        self._channel, self._readback = channel, options.get("readback")
        self._level_per_v: float = options["per_volt"]
        self._frequency_hz: float = options["frequency"]
        self._rate_hz = options.get("rate", SAMPLES_PER_PERIOD * self._frequency_hz)
        try:
            self.limits.check_frequency(self._frequency_hz)
        except OverLimit as error:
            raise UserError("plate 'daq': {error}", error=error) from None
        samples = PERIODS * self._rate_hz / self._frequency_hz
        if samples < 4 * PERIODS or abs(samples - round(samples)) > 1e-6 * samples:
            raise UserError(
                "plate 'daq': rate is {rate_hz:g} Hz, but {periods} periods of {frequency_hz:g} "
                "Hz must be a whole number of samples, with at least 4 per period; expected a "
                "multiple of the frequency",
                rate_hz=self._rate_hz,
                periods=PERIODS,
                frequency_hz=self._frequency_hz,
            )
        phase = 2 * math.pi * PERIODS * np.arange(round(samples)) / round(samples)
        self._sine, self._cosine = np.sin(phase), np.cos(phase)
        self.attention_s = options.get("attention", self.attention_s)
        emulated = channel.startswith(EMULATED_DEVICE)
        self.instrument = "" if emulated else channel
        self.unattended = (
            StopsAlone("the device is emulated by this process")
            if emulated
            else Guarded(partial(GuardedDaq, channel))
        )
        self._library: Any = daq_device if emulated else load_library()
        self._serial = f"{EMULATED}-daq" if emulated else channel.partition("/")[0]
        self._task: Any = None
        self._level = 0.0

    def _check_possible(self, level: float) -> None:
        needed_v = level / self._level_per_v
        if needed_v > TERMINAL_V:
            raise OverLimit(
                "{level} needs {needed_v:.2f} V at the terminal, which supplies at most "
                "{terminal_v:g} V",
                level=self.limits.quantity.short(level),
                needed_v=needed_v,
                terminal_v=TERMINAL_V,
            )

    def _connect(self) -> PlateIdentity:
        self._zero()
        return PlateIdentity(
            manufacturer="National Instruments",
            model=f"analogue output {self._channel}",
            serial=self._serial,
            firmware="unknown",
        )

    def _drive(self, level: float) -> Presentation:
        begun_s, before = self.clock.now(), self._level
        if self._task is None:
            self._task = self._asked(self._start)
        for step in range(1, RAMP_STEPS + 1):
            self._write(along_edge(before, level, step / RAMP_STEPS))
            self.clock.sleep(RAMP_S / RAMP_STEPS)
        self.clock.sleep(PERIODS / self._frequency_hz)
        if level == 0:
            self._zero()
        readback = self._read_back()
        return Presentation(
            commanded_level=level,
            readback=readback,
            settled_by="wait",
            settle_time_s=self.clock.now() - begun_s,
        )

    def _read_back(self) -> Readback:
        if self._readback is None or self._task is None:
            kind = "commanded" if self._readback is None else "applied"
            return Readback(level=self._level, kind=kind, time_s=self.clock.now())  # type: ignore[arg-type]
        volts = self._asked(self._measure)
        amplitude_v = 2 * math.hypot(float(volts @ self._sine), float(volts @ self._cosine))
        level = amplitude_v / len(volts) * self._level_per_v
        return Readback(level=level, kind="applied", time_s=self.clock.now())

    def _silence(self) -> None:
        if self._task is None and self._level == 0:
            return
        try:
            self._zero()
        except ConnectionLost as error:
            raise StillVibrating(
                "plate 'daq': {channel} did not confirm 0 V ({error}); switch the amplifier off",
                channel=self._channel,
                error=error,
            ) from error

    def _close(self) -> None:
        task, self._task = self._task, None
        if task is not None:
            self._asked(task.close)

    def _start(self) -> Any:
        task = self._library.Task()
        task.ao_channels.add_ao_voltage_chan(self._channel, min_val=-TERMINAL_V, max_val=TERMINAL_V)
        task.timing.cfg_samp_clk_timing(
            self._rate_hz,
            sample_mode=self._library.constants.AcquisitionType.CONTINUOUS,
            samps_per_chan=len(self._sine),
        )
        return task

    def _write(self, level: float) -> None:
        self._level = max(self._level, level)  # The larger level counts until the write succeeds.
        samples = level / self._level_per_v * self._sine
        self._asked(lambda: self._task.write(samples.tolist(), auto_start=True))
        self._level = level

    def _zero(self) -> None:
        """Stop the sine wave and set the output to 0 V. Raises `ConnectionLost` if either fails."""
        self._close()
        self._asked(partial(hold_at_zero, self._library, self._channel))
        self._level = 0.0

    def _measure(self) -> Any:
        with self._library.Task() as task:
            task.ai_channels.add_ai_voltage_chan(self._readback)
            task.timing.cfg_samp_clk_timing(self._rate_hz, samps_per_chan=len(self._sine))
            return np.array(task.read(number_of_samples_per_channel=len(self._sine)))

    def _asked(self, request: Callable[[], Any]) -> Any:
        try:
            return request()
        except self._library.errors.Error as error:
            raise ConnectionLost(
                "plate 'daq': {error}", error=str(error).partition(chr(10))[0]
            ) from error


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:  # noqa: ARG001
    """Return the driver for an analogue output (entry point ``daq``). Raises `UserError`."""
    channel, options, plate = addresses.opened(address, DaqOutput.name, OPTIONS)
    missing = [name for name in ("plate", "frequency", "per_volt") if name not in options]
    if missing or "/" not in channel:
        raise UserError(
            "plate 'daq:{address}': expected a channel such as Dev1/ao0, and "
            "plate=FILE,frequency=HZ,per_volt=LEVEL",
            address=address,
        )
    return DaqOutput(channel, options, clock=clock, plate=plate)
