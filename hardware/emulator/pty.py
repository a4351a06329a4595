"""Connect an emulated board to a pseudo-terminal, for `slipscale plate emulate`.

The port's path is a symbolic link, so it stays the same when the board is unplugged and plugged in
again.
"""

from __future__ import annotations

import os
import select
import sys
import tempfile
import time
import tty
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.hardware.emulator.emulator import Emulator

TICK_S = 0.001
IDLE_TICK_S = 0.01  # used while the plate is off and no answers remain to be sent


class PseudoTerminal:
    """Board's end of a serial line to a host on this computer.

    Attributes
    ----------
    port : Path
        Symbolic link to the host's end.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="slipscale-plate-")
        self.port = Path(self._folder.name, "port")
        self._master: int | None = None
        self._host_is_there = False

    def plug_in(self) -> None:
        """Create a pseudo-terminal and the symbolic link to it.

        The emulator closes its own copy of the host's end, so that it is notified when the host
        closes the port.
        """
        if sys.platform == "win32":  # where importing tty fails already; for the type checker
            raise NotImplementedError
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        self.port.symlink_to(os.ttyname(slave))
        os.close(slave)
        self._host_is_there = False

    def unplug(self) -> None:
        """Close the pseudo-terminal."""
        if self._master is not None:
            # The symbolic link is deleted, because another program may get the same terminal.
            self.port.unlink()
            os.close(self._master)
            self._master = None

    def send(self, data: bytes) -> None:
        """Send bytes to the host."""
        if self._master is not None:
            with suppress(OSError):  # The host has closed the port or does not read from it.
                os.write(self._master, data)

    def turn(self, emulator: Emulator, control: int | None = None) -> bool:
        """Process events for up to one tick, and return whether a control command is available."""
        emulator.advance()
        tick_s = TICK_S if emulator.active else IDLE_TICK_S
        watched = [each for each in (self._master, control) if each is not None]
        ready, _, _ = select.select(watched, [], [], tick_s)
        if self._master in ready:
            self._read(emulator, tick_s)
        return control in ready

    def close(self) -> None:
        """Delete the temporary folder of the port."""
        self._folder.cleanup()

    def _read(self, emulator: Emulator, tick_s: float) -> None:
        if self._master is None:
            return
        try:
            data = os.read(self._master, 4096)
        except OSError:  # No host has opened the port yet.
            if self._host_is_there:
                emulator.host_left()
            self._host_is_there = False
            time.sleep(tick_s)
            return
        self._host_is_there = True
        emulator.receive(data)
