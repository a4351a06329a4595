"""Track which consoles are open on a folder, using one file lock per console.

The operating system releases the lock when the process ends, so a killed console leaves only an
unlocked file. The folder that contains these files is writable only by the user.
"""

from __future__ import annotations

import hashlib
import time
from contextlib import suppress
from pathlib import Path
from typing import IO

import portalocker

from slipscale.faults.message import Message
from slipscale.faults.private_folder import private_folder


class Presence:
    """Lock file of a console, for detecting other consoles that are open on the same folder.

    Parameters
    ----------
    folder : Path
        The laboratory folder.
    port : int
        The port on which this console listens.
    """

    def __init__(self, folder: Path, port: int) -> None:
        key = hashlib.sha256(str(folder.resolve()).encode()).hexdigest()[:16]
        self._prefix = f"slipscale-console-{key}-"
        self._place = private_folder()
        self._own = self._place / f"{self._prefix}{time.time_ns()}-{port}"
        self._held: IO[bytes] | None = None

    def announce(self) -> None:
        """Announce this console to other consoles of the same folder, until `close` is called."""
        # If the file cannot be locked, the other consoles ignore this console.
        with suppress(OSError, portalocker.LockException):
            self._held = self._own.open("wb")
            portalocker.lock(self._held, portalocker.LOCK_EX | portalocker.LOCK_NB)

    def others(self) -> list[int]:
        """Return the ports of the other consoles."""
        return [_port(path) for path in self._open() if path != self._own]

    def first(self) -> bool:
        """Return whether this console was opened first; only the first performs shared tasks."""
        return next((path == self._own for path in self._open()), True)

    def notices(self) -> tuple[str, ...]:
        """Return a notice about other consoles, if any."""
        ports = ", ".join(str(port) for port in self.others())
        if not ports:
            return ()
        sentence = Message(
            "another console for this folder is open (port {ports}): all consoles show and "
            "control the same session, and the first request takes effect",
            ports=ports,
        )
        return (sentence,)

    def close(self) -> None:
        """Withdraw the announcement."""
        if self._held:
            self._held.close()
            self._held = None
            with suppress(OSError):
                self._own.unlink()

    def _open(self) -> list[Path]:
        """Return the locked files, oldest first; remove files left behind by killed consoles."""
        held = []
        for path in sorted(self._place.glob(f"{self._prefix}*")):
            if (path == self._own and self._held) or _is_held(path):
                held.append(path)
            else:
                with suppress(OSError):
                    path.unlink()
        return held


def _is_held(path: Path) -> bool:
    try:
        with path.open("rb") as stream:
            portalocker.lock(stream, portalocker.LOCK_SH | portalocker.LOCK_NB)
    except portalocker.LockException:
        return True
    except OSError:
        return False
    return False


def _port(path: Path) -> int:
    return int(path.name.rpartition("-")[2])
