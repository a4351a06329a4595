"""Emulate a data acquisition device in memory, with the interface of ``nidaqmx``.

The emulated input reads the voltage of the emulated output. Like a real device, the emulated device
rejects voltages outside its range and a second task on a channel. When a task ends, the output
keeps its last voltage.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from itertools import cycle, islice
from types import SimpleNamespace
from typing import Self

RANGE_V = 10.0


class Error(Exception):
    """Error raised by the emulated library."""


class AcquisitionType(Enum):
    """Number of samples in a task: a fixed number, or samples until the task is stopped."""

    FINITE = "finite"
    CONTINUOUS = "continuous"


errors = SimpleNamespace(Error=Error)
constants = SimpleNamespace(AcquisitionType=AcquisitionType)


class Terminals:
    """State of the emulated device: its output, its connection and the wiring of its input."""

    def __init__(self) -> None:
        self.output_v: list[float] = [0.0]
        self.reserved = False
        self.unplugged = False
        self.wired = True

    def ask(self) -> None:
        """Raise `Error` if the device cannot be reached."""
        if self.unplugged:
            raise Error("Device cannot be accessed.")


TERMINALS = Terminals()


class Task:
    """Task on the emulated device; see the documentation of ``nidaqmx``."""

    def __init__(self) -> None:
        TERMINALS.ask()
        self.ao_channels = self.ai_channels = self.timing = self
        self._reserves = False

    def add_ao_voltage_chan(self, _channel: str, *, min_val: float, max_val: float) -> None:
        """Reserve the output."""
        if TERMINALS.reserved:
            raise Error("The specified resource is reserved.")
        if max(-min_val, max_val) > RANGE_V:
            raise Error("Requested value is not a supported value for this property.")
        self._reserves = TERMINALS.reserved = True

    def add_ai_voltage_chan(self, _channel: str) -> None:
        """Add the input."""

    def cfg_samp_clk_timing(
        self,
        rate: float,
        sample_mode: AcquisitionType = AcquisitionType.FINITE,
        samps_per_chan: int = 1000,
    ) -> None:
        """Set the sample clock."""

    def write(self, data: float | Sequence[float], *, auto_start: bool) -> None:  # noqa: ARG002
        """Output one voltage, or repeat a buffer of voltages."""
        TERMINALS.ask()
        volts = [data] if isinstance(data, float) else list(data)
        if max(map(abs, volts)) > RANGE_V:
            raise Error("Attempted to write a sample beyond the valid range.")
        TERMINALS.output_v = volts

    def read(self, number_of_samples_per_channel: int) -> list[float]:
        """Return the current output."""
        TERMINALS.ask()
        volts = TERMINALS.output_v if TERMINALS.wired else [0.0]
        return list(islice(cycle(volts), number_of_samples_per_channel))

    def close(self) -> None:
        """Free the output channel for other tasks; its voltage does not change."""
        if self._reserves:
            TERMINALS.reserved = self._reserves = False
        TERMINALS.ask()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
