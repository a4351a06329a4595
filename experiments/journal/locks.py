"""One writer of a journal at a time: the system's lock, and a lock file as the second line.

The system's lock goes with the process and is never left behind, but some network drives have
none. So a writer also leaves a file beside the journal that names its host and process. Such a
file may be left behind by a crash: it counts only as long as it can be believed.
"""

from __future__ import annotations

import os
import socket
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import portalocker

from slipscale.faults import UserError

if TYPE_CHECKING:
    from io import FileIO
    from pathlib import Path
    from typing import IO

# A session on another computer touches its lock file at each record. Longer than this between two
# records is a session that has gone, not a participant who thinks.
STALE_S = 900.0
# Taking a lock is a matter of milliseconds; what is older was left by a crash in between.
CLAIM_S = 10.0
LOOKS, LOOK_S = 5, 0.02


@dataclass(frozen=True, slots=True)
class Holder:
    """Who wrote a lock file."""

    host: str
    process: int

    def __str__(self) -> str:
        """Return host and process in words."""
        return f"process {self.process} on {self.host}"


def lock_file(journal: Path) -> Path:
    """Return where a journal's lock file lies."""
    return journal.with_name(f"{journal.name}.lock")


def writer(journal: Path) -> Holder | None:
    """Return whom a journal's lock file names, writing or not; None without such a file."""
    try:
        host, process = lock_file(journal).read_text(encoding="utf-8").split()
        return Holder(host, int(process))
    except (OSError, ValueError):
        return None


def has_locks(stream: IO[bytes]) -> bool:
    """Return whether the file system of an open file, which nobody else has locked, has locks."""
    return _lock(stream, portalocker.LOCK_EX) is not None


def is_being_written(journal: Path) -> bool:
    """Return whether a session writes a journal now; False where there is none to be seen."""
    try:
        with journal.open("rb") as stream:
            free = _lock(stream, portalocker.LOCK_SH)
    except OSError:
        return False
    holder = _believed(journal, system_locks=free is not None, now_s=time.time())
    return free is False or holder is not None


def take(stream: FileIO, journal: Path) -> None:
    """Lock an open journal for writing, and leave the lock file.

    Raises
    ------
    UserError
        Another session writes it.
    """
    free = _lock(stream, portalocker.LOCK_EX)
    for _ in range(LOOKS):
        if free is not False:
            break
        # Whoever looks whether a session writes it (the console) holds it for an instant.
        time.sleep(LOOK_S)
        free = _lock(stream, portalocker.LOCK_EX)
    if free is False:
        raise UserError(f"journal {journal}: another session is writing it")
    _leave_lock_file(journal, system_locks=free is not None)


def refresh(journal: Path) -> None:
    """Tell other computers that the writer is still there."""
    with suppress(OSError):
        os.utime(lock_file(journal))


def release(journal: Path) -> None:
    """Take the lock file away; the system's lock goes with the open file."""
    with suppress(OSError):
        lock_file(journal).unlink()


def _lock(stream: IO[bytes] | FileIO, kind: portalocker.LockFlags) -> bool | None:
    """Lock a file; return whether that was possible, None where its file system has no locks."""
    try:
        portalocker.lock(stream, kind | portalocker.LOCK_NB)
    except portalocker.AlreadyLocked:
        return False
    except portalocker.LockException:
        return None
    return True


def _leave_lock_file(journal: Path, *, system_locks: bool) -> None:
    """Leave our lock file, unless another session's can be believed.

    Two that come at once must not both find no lock file, or both replace the one that a crash
    left. So each first makes a second file, which the system lets only one do, and gives it the
    lock file's name once it has looked.
    """
    lock = lock_file(journal)
    claim = lock.with_name(f"{lock.name}.new")
    try:
        if not (_make(claim) or _make_again(claim, system_locks=system_locks)):
            raise UserError(f"journal {journal}: another session is just beginning to write it")
        # The claim's date is the file system's own: this computer's clock may be wrong.
        now_s = claim.stat().st_mtime
        holder = _believed(journal, system_locks=system_locks, now_s=now_s)
        if holder is None:
            os.replace(claim, lock)  # noqa: PTH105 - Path.replace is the same call
            return
        claim.unlink(missing_ok=True)
    except OSError:
        return  # where it cannot be written, the journal itself will say so at its first record
    raise UserError(
        f"journal {journal}: another session is writing it ({holder}); if none runs there, "
        f"delete {lock}"
    )


def _make(claim: Path) -> bool:
    """Make a lock file under its first name; return whether nobody else has."""
    try:
        with claim.open("x", encoding="utf-8") as file:
            file.write(f"{socket.gethostname()}\n{os.getpid()}\n")
    except FileExistsError:
        return False
    return True


def _make_again(claim: Path, *, system_locks: bool) -> bool:
    """Make it in place of one that a crash left; return whether that could be, and was, done.

    Who has the system's lock knows that nobody else is about to.
    """
    try:
        if not system_locks and abs(time.time() - claim.stat().st_mtime) < CLAIM_S:
            return False
    except FileNotFoundError:
        return False  # its maker has just given it the other name
    claim.unlink(missing_ok=True)
    return _make(claim)


def _believed(journal: Path, *, system_locks: bool, now_s: float) -> Holder | None:
    """Return who a lock file says is writing, as far as it can be believed."""
    holder = writer(journal)
    try:
        age_s = now_s - lock_file(journal).stat().st_mtime
    except OSError:
        return None
    if holder is None:
        return None
    if holder.host != socket.gethostname():
        return holder if age_s < STALE_S else None
    # On this computer the system's lock knows better, where there is one.
    mine = holder.process == os.getpid()
    return None if system_locks or mine or not _runs(holder.process) else holder


def _runs(process: int) -> bool:
    """Return whether a process of this computer runs."""
    if os.name == "nt":  # os.kill would end it there
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True
