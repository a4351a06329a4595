"""Allow only one writer per journal at a time, with a system lock and a lock file.

The system releases its lock when the process ends. Because some network drives do not support
locks, a writer also creates a lock file next to the journal, with the writer's host name and
process ID. A crash may leave a lock file behind, so implausible lock files are ignored.
"""

from __future__ import annotations

import os
import socket
import time
from contextlib import suppress
from dataclasses import dataclass
from io import FileIO
from pathlib import Path
from typing import IO

import portalocker

from slipscale.faults import UserError

# A session on another computer updates its lock file whenever it writes a record. If the lock file
# is older than this, the session has ended, because no participant thinks for this long. A lock
# file from the future says as little: clocks of two computers do not differ by this much.
STALE_S = 900.0
# Taking a lock takes milliseconds, so an older temporary lock file was left behind by a crash.
CLAIM_S = 10.0
LOOKS, LOOK_S = 5, 0.02


@dataclass(frozen=True, slots=True)
class Holder:
    """The process that a lock file names as the writer of a journal."""

    host: str
    process: int

    def __str__(self) -> str:
        """Return the process ID and the host name in words."""
        return f"process {self.process} on {self.host}"


def lock_file(journal: Path) -> Path:
    """Return the path of a journal's lock file."""
    return journal.with_name(f"{journal.name}.lock")


def writer(journal: Path) -> Holder | None:
    """Return the process named in a lock file, running or not; None without a readable file."""
    try:
        host, process = lock_file(journal).read_text(encoding="utf-8").split()
        return Holder(host, int(process))
    except (OSError, ValueError):
        return None


def has_locks(stream: IO[bytes]) -> bool:
    """Return whether the file system supports locks; ``stream`` must be open and not locked."""
    return _lock(stream, portalocker.LOCK_EX) is not None


def is_being_written(journal: Path) -> bool:
    """Return whether a session is writing to a journal (False if the journal does not exist)."""
    try:
        with journal.open("rb") as stream:
            free = _lock(stream, portalocker.LOCK_SH)
    except OSError:
        return False
    holder = _believed(journal, system_locks=free is not None, now_s=time.time())
    return free is False or holder is not None


def take(stream: FileIO, journal: Path) -> None:
    """Lock an open journal for writing, and create its lock file.

    Raises
    ------
    UserError
        If another session is writing to the journal.
    """
    free = _lock(stream, portalocker.LOCK_EX)
    for _ in range(LOOKS):
        if free is not False:
            break
        # A process that checks for a writer, such as the console, holds the lock briefly.
        time.sleep(LOOK_S)
        free = _lock(stream, portalocker.LOCK_EX)
    if free is False:
        raise UserError("journal {journal}: another session is writing to it", journal=journal)
    _leave_lock_file(journal, system_locks=free is not None)


def refresh(journal: Path) -> None:
    """Update the time of the lock file, so that other computers see that the writer is active."""
    with suppress(OSError):
        os.utime(lock_file(journal))


def release(journal: Path) -> None:
    """Remove the lock file; the system lock is released when the file is closed."""
    with suppress(OSError):
        lock_file(journal).unlink()


def _lock(stream: IO[bytes] | FileIO, kind: portalocker.LockFlags) -> bool | None:
    """Lock a file and return whether this succeeded, or None if locks are not supported."""
    try:
        portalocker.lock(stream, kind | portalocker.LOCK_NB)
    except portalocker.AlreadyLocked:
        return False
    except portalocker.LockException:
        return None
    return True


def _leave_lock_file(journal: Path, *, system_locks: bool) -> None:
    """Create a lock file for this session, unless another session is probably still active.

    If two sessions start simultaneously, only one of them may create or replace the lock file. Each
    session therefore first creates a temporary file; only one session at a time can succeed in
    creating this file. The session then checks the existing lock file and replaces it with the
    temporary file.
    """
    lock = lock_file(journal)
    claim = lock.with_name(f"{lock.name}.new")
    try:
        if not (_make(claim) or _make_again(claim, system_locks=system_locks)):
            raise UserError(
                "journal {journal}: another session is about to write to it", journal=journal
            )
        # The new file's time is the current time of the file system, whose clock may differ from
        # this computer's.
        now_s = claim.stat().st_mtime
        holder = _believed(journal, system_locks=system_locks, now_s=now_s)
        if holder is None:
            os.replace(claim, lock)  # noqa: PTH105 - Path.replace is the same call
            return
        claim.unlink(missing_ok=True)
    except OSError:
        return  # If the folder is not writable, the first record cannot be written either.
    raise UserError(
        "journal {journal}: another session is writing to it ({holder}); if no session is "
        "running there, delete {lock}",
        journal=journal,
        holder=holder,
        lock=lock,
    )


def _make(claim: Path) -> bool:
    """Create the temporary lock file; return False if another session has already created it."""
    try:
        with claim.open("x", encoding="utf-8") as file:
            file.write(f"{socket.gethostname()}\n{os.getpid()}\n")
    except FileExistsError:
        return False
    return True


def _make_again(claim: Path, *, system_locks: bool) -> bool:
    """Replace a temporary lock file left behind by a crash; return whether it was replaced.

    Without a system lock, a recent file is not replaced, because its session may still be starting.
    """
    try:
        if not system_locks and abs(time.time() - claim.stat().st_mtime) < CLAIM_S:
            return False
    except FileNotFoundError:
        return False  # Another session has just renamed it.
    claim.unlink(missing_ok=True)
    return _make(claim)


def _believed(journal: Path, *, system_locks: bool, now_s: float) -> Holder | None:
    """Return the writer named in a lock file, if this writer is probably still active."""
    holder = writer(journal)
    try:
        age_s = now_s - lock_file(journal).stat().st_mtime
    except OSError:
        return None
    if holder is None:
        return None
    if holder.host != socket.gethostname():
        return holder if abs(age_s) < STALE_S else None
    # For processes on this computer, the system lock (if supported) is more reliable than the file.
    mine = holder.process == os.getpid()
    return None if system_locks or mine or not _runs(holder.process) else holder


def _runs(process: int) -> bool:
    if os.name == "nt":  # On Windows, os.kill would end the process.
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True
