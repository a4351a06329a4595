"""Read forces from a National Instruments data acquisition device.

SPEC: ``daq:normal=Dev1/ai0,lateral=Dev1/ai1,normal_scale=10,lateral_scale=5`` with

=================================  ============================================================
``normal``, ``lateral``            the device's voltage channels; required
``normal_scale``, ...              N per volt; required: the load cell's own calibration
``normal_zero``, ...               volts without force (0)
``rate``                           samples per second (1000)
=================================  ============================================================

The library ``nidaqmx`` is installed by ``pip install slipscale[daq]`` and requires NI's driver.
**This source has not been tested on a real device.**
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from slipscale.faults import UserError
from slipscale.hardware import address as addresses
from slipscale.hardware.backends.daq_library import load_library
from slipscale.hardware.contact.source import (
    FORCE,
    ContactSource,
    Sample,
    SensorFault,
    Surroundings,
)

RATE_HZ = 1000.0
BUFFER_S = 10.0  # length of the device's buffer
FIRST_TRIES, FIRST_WAIT_S = 50, 0.02
NAMES = ("normal", "lateral")


def _channel(text: str) -> str:
    if not text:
        raise ValueError("expected a channel such as Dev1/ai0")
    return text


OPTIONS: dict[str, Callable[[str], object]] = {"rate": addresses.positive_number}
for _name in NAMES:
    OPTIONS |= {
        _name: _channel,
        f"{_name}_scale": addresses.number,
        f"{_name}_zero": addresses.number,
    }


class DaqForces(ContactSource):
    """Force sensors read through two voltage channels.

    Parameters
    ----------
    surroundings : Surroundings
    options : dict
        See the module's documentation.
    """

    name: ClassVar[str] = "daq"
    quantities = FORCE

    def __init__(self, surroundings: Surroundings, options: dict[str, Any]) -> None:
        self._clock = surroundings.clock
        self._options = options
        self._rate_hz: float = options.get("rate", RATE_HZ)
        self._library = load_library()
        self._task: Any = None
        self._lost = False

    def connect(self) -> None:
        """Open the channels, and wait for the first reading."""
        self.close()
        self._lost = False
        try:
            self._task = self._library.Task()
            for name in NAMES:
                self._task.ai_channels.add_ai_voltage_chan(self._options[name])
            self._task.timing.cfg_samp_clk_timing(
                self._rate_hz,
                sample_mode=self._library.constants.AcquisitionType.CONTINUOUS,
                samps_per_chan=int(self._rate_hz * BUFFER_S),
            )
            self._task.start()
        except self._library.errors.Error as error:
            raise SensorFault("daq: {first_line}", first_line=_first_line(error)) from error
        for _ in range(FIRST_TRIES):
            if self.take():
                return
            self._clock.sleep(FIRST_WAIT_S)
        raise SensorFault("daq: no reading was received")

    def begin(self) -> None:
        """Discard earlier samples; reopen the device if it was lost."""
        if self._lost:
            self.connect()
        self.take()

    def take(self) -> list[Sample]:
        """Return the samples since the last call. The newest sample gets the current time."""
        if self._task is None:
            raise SensorFault("daq: not connected")
        try:
            volts = self._task.read(
                number_of_samples_per_channel=self._library.constants.READ_ALL_AVAILABLE
            )
        except self._library.errors.Error as error:
            self._lost = True
            raise SensorFault("daq: {first_line}", first_line=_first_line(error)) from error
        now_s, count = self._clock.now(), len(volts[0])
        forces = [
            [
                (v - self._options.get(f"{name}_zero", 0.0)) * self._options[f"{name}_scale"]
                for v in channel
            ]
            for name, channel in zip(NAMES, volts, strict=True)
        ]
        return [
            Sample(now_s - (count - 1 - number) / self._rate_hz, values)
            for number, values in enumerate(zip(*forces, strict=True))
        ]

    def close(self) -> None:
        """Release the device."""
        task, self._task = self._task, None
        if task is not None:
            task.close()

    def describe(self) -> dict[str, object]:
        """Return the name, channels, scales and sampling rate, as JSON data."""
        return {"name": self.name, **self._options, "rate": self._rate_hz}


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0].rstrip(".")


def open_force(address: str, surroundings: Surroundings) -> ContactSource:
    """Return a source of forces (entry point ``daq``). Raises `UserError`."""
    _, options = addresses.split_address(address, OPTIONS, what="--force daq")
    needed = [key for name in NAMES for key in (name, f"{name}_scale")]
    if missing := [key for key in needed if key not in options]:
        raise UserError(
            "--force 'daq:{address}': also requires {missing}",
            address=address,
            missing=", ".join(missing),
        )
    return DaqForces(surroundings, options)
