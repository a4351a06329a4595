"""Switch an analogue output off from the guard process, whatever the session's process does."""

from __future__ import annotations

from importlib import import_module

from slipscale.hardware.backends.daq_library import hold_at_zero, load_library
from slipscale.hardware.errors import ConnectionLost


class GuardedDaq:
    """Analogue output that belongs to another process.

    Parameters
    ----------
    channel : str
        Name of the analogue output, such as Dev1/ao0.
    """

    def __init__(self, channel: str) -> None:
        self._channel = channel
        self._library = load_library()
        self._system = import_module("nidaqmx.system")

    def switch_off(self) -> None:
        """Abort all tasks on the device, and set the output to 0 V. Raises `ConnectionLost`."""
        try:
            self._system.Device(self._channel.partition("/")[0]).reset_device()
            hold_at_zero(self._library, self._channel)
        except self._library.errors.Error as error:
            raise ConnectionLost("plate 'daq': {error}", error=error) from error
