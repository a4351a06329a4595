"""Let only one process of this user drive an instrument at a time.

Without this lock, two sessions could drive one plate, and each participant would feel the level of
the other. The lock is a lock of the operating system on a file, so it ends with the processes that
hold it: the session, and a guard that still tries to switch its output off.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import IO

import portalocker

from slipscale.faults.message import Message
from slipscale.faults.private_folder import private_folder
from slipscale.hardware.errors import PlateBusy

COMMAND_CHARACTERS = 60
ENDING_S, LOOK_S = 2.0, 0.02


class InstrumentLock:
    """Lock of one instrument.

    Parameters
    ----------
    instrument : str
        Name that is the same for all addresses of the instrument.

    Raises
    ------
    PlateBusy
        If another driver holds the lock; the message names its process and its start.
    """

    def __init__(self, instrument: str) -> None:
        key = hashlib.sha256(instrument.encode()).hexdigest()[:16]
        path = private_folder() / f"slipscale-instrument-{key}"
        about = path.with_suffix(".json")
        self._file: IO[bytes] = path.open("wb")
        try:
            self._lock()
        except portalocker.AlreadyLocked:
            self._file.close()
            raise PlateBusy(
                "{instrument}: it is driven by {holder}",
                instrument=instrument,
                holder=_holder(about),
                level_free=True,
            ) from None
        except portalocker.LockException:
            return  # The folder's file system has no locks.
        with suppress(OSError):
            about.write_text(json.dumps(_this_process()), encoding="utf-8")

    def _lock(self) -> None:
        """Lock the file; wait for the guard of a session that was just killed."""
        end_s = time.monotonic() + ENDING_S
        while True:
            try:
                portalocker.lock(self._file, portalocker.LOCK_EX | portalocker.LOCK_NB)
            except portalocker.AlreadyLocked:
                if time.monotonic() > end_s:
                    raise
                time.sleep(LOOK_S)
            else:
                return

    @property
    def descriptor(self) -> int:
        """Descriptor of the file; a process that inherits it holds the lock as well."""
        return self._file.fileno()

    def release(self, *, shared: bool) -> None:
        """Release the lock; if it is ``shared``, the other process keeps it."""
        if not shared:
            with suppress(portalocker.LockException):
                portalocker.unlock(self._file)
        self._file.close()


def _this_process() -> dict[str, str]:
    command = " ".join(Path(sys.argv[0]).name.split()[:1] + sys.argv[1:])
    now = datetime.now().astimezone().isoformat(sep=" ", timespec="seconds")
    return {"process": f"{os.getpid()}", "command": command[:COMMAND_CHARACTERS], "started": now}


def _holder(about: Path) -> str:
    try:
        found = json.loads(about.read_text(encoding="utf-8"))
        return Message("process {process} ({command}) since {started}", **found)
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
