"""Read and write a serial port; all failures raise a `PlateFault`.

The port is opened exclusively and read without blocking. All exceptions that pyserial raises for an
unplugged device are converted to `ConnectionLost`.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

from slipscale.hardware.errors import (
    ConnectionLost,
    NoPermission,
    PlateBusy,
    PlateFault,
    PlateNotFound,
)

# A TypeError means that another thread closed the port during a read. pyserial's own exceptions are
# OSErrors.
UNPLUGGED: tuple[type[Exception], ...] = (OSError, TypeError)
with suppress(ImportError):  # Windows has no termios
    if sys.platform != "win32":
        import termios

        UNPLUGGED += (termios.error,)  # pyserial can raise it; it is not an OSError.

T = TypeVar("T")

BAUD = 115_200
SLICE_S = 0.01  # longest wait of one read

OPENING: dict[int, tuple[type[PlateFault], str]] = {
    errno.ENOENT: (PlateNotFound, "no such port"),
    errno.ENXIO: (PlateNotFound, "no device at this port"),
    errno.ENODEV: (PlateNotFound, "no device at this port"),
    errno.EIO: (PlateNotFound, "no device at this port"),
    errno.EACCES: (NoPermission, "no permission to open this port"),
    errno.EPERM: (NoPermission, "no permission to open this port"),
    errno.EBUSY: (PlateBusy, "another program is using this port"),
    errno.EAGAIN: (PlateBusy, "another program is using this port"),
}


class SerialLine:
    """Open serial port.

    Parameters
    ----------
    port : str
        ``/dev/ttyACM0``, ``COM3``, or any URL that pyserial supports (``spy://`` logs the traffic).
    baud : int
        Baud rate.
    """

    def __init__(self, port: str, *, baud: int = BAUD) -> None:
        import serial

        self.port = port
        try:
            self._serial = serial.serial_for_url(
                port, baudrate=baud, timeout=SLICE_S, write_timeout=1.0, exclusive=True
            )
        except ValueError as error:
            raise _opening_fault(port, error) from error
        except UNPLUGGED as error:
            raise _opening_fault(port, error) from error

    def write(self, data: bytes) -> None:
        """Send bytes. Raises `ConnectionLost`."""
        self._do(lambda: self._serial.write(data))

    def read(self) -> bytes:
        """Return the available bytes, or wait `SLICE_S` for a byte. Raises `ConnectionLost`."""
        data: bytes = self._do(lambda: self._serial.read(self._serial.in_waiting or 1))
        return data

    def close(self) -> None:
        """Close the port. Never raises."""
        with suppress(*UNPLUGGED):
            self._serial.close()

    def _do(self, action: Callable[[], T]) -> T:
        try:
            return action()
        except UNPLUGGED as error:
            raise ConnectionLost(
                "{port}: the device was disconnected ({error})", port=self.port, error=error
            ) from error


def _opening_fault(port: str, error: Exception) -> PlateFault:
    # On Windows, pyserial provides no errno, but the message contains the text from Windows.
    number = getattr(error, "errno", None)
    if number in OPENING:
        fault, what = OPENING[number]
        return fault("{port}: {what}", port=port, what=what, level_free=True)
    if "PermissionError" in str(error):
        return PlateBusy("{port}: another program is using this port", port=port, level_free=True)
    return PlateNotFound("{port}: cannot be opened ({error})", port=port, error=error)
