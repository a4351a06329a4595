"""Simulate faulty disks and killed processes in a file layer below the journal.

A kill is simulated by an exception that Slipscale does not catch. Afterwards, the session can no
longer write to the disk. This is fast, so a run can be killed at every record. For processes that
receive SIGKILL, see `tools.campaigns.torture.system_calls`.
"""

from __future__ import annotations

import errno
import os
import random
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from unittest import mock

from slipscale.experiments.journal import journal as journal_module
from slipscale.experiments.journal.journal import Journal

SECTOR = 512
# Faults that end the process at the write of a record.
KILLS = ("kill before", "kill within", "kill after", "power cut")
# Such a run is killed LIVES times, each time within LIFE records and in a different way.
AGAIN, LIVES, LIFE = "repeated kills", 6, 12
ERRORS = {
    "EIO": errno.EIO,
    "ENOSPC": errno.ENOSPC,
    "EROFS": errno.EROFS,
}
WITHIN = tuple(f"{name} {place}" for name in ERRORS for place in ("at once", "halfway"))
GONE = ("removed", "renamed", "folder removed", "folder renamed")
FAULTS = (*KILLS, AGAIN, *WITHIN, "fsync EIO", "short writes", *GONE)


class Killed(BaseException):
    """The process is dead and can no longer write to the disk."""


class Disk:
    """File layer below a journal, in which a fault occurs at a given write.

    Parameters
    ----------
    fault : str
        One of `FAULTS`.
    at : int
        Index of the write that fails, from 0, or -1 for none.

    Attributes
    ----------
    writes : int
        Number of writes so far.
    kills : int
        Number of times the process died.
    struck : bool
        Whether the fault has occurred.
    """

    def __init__(self, fault: str, at: int) -> None:
        self.fault, self.at = fault, at
        self.writes = 0
        self.kills = 0
        self.dead = False
        self.struck = False
        self.kept = 0  # bytes that were synchronised to the disk
        self._random = random.Random(f"{fault}/{at}")
        self._fsync = os.fsync

    def write(self, stream: Stream, line: bytes) -> int:
        """Write a record, or inject the fault."""
        if self.dead:
            raise Killed
        number, self.writes = self.writes, self.writes + 1
        if number != self.at:
            return stream.raw(line)
        self.struck = True
        half = len(line) // 2
        fault = self._random.choice(KILLS) if self.fault == AGAIN else self.fault
        if fault in KILLS:
            self.dead = True
            self.kills += 1
            part = {"kill before": b"", "kill within": line[:half], "kill after": line}
            stream.raw(part.get(fault, line))
            if fault == "power cut":
                self._lose_sectors(stream)
            raise Killed
        name, _, place = fault.partition(" ")
        if name in ERRORS:
            stream.raw(line[:half] if place == "halfway" else b"")
            raise OSError(ERRORS[name], os.strerror(ERRORS[name]))
        return stream.raw(line[: max(half, 1)] if fault == "short writes" else line)

    def fsync(self, descriptor: int) -> None:
        """Synchronise, or fail."""
        if self.dead:
            raise Killed
        if self.fault == "fsync EIO" and -1 < self.at < self.writes and not self.struck:
            self.struck = True
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        length = os.fstat(descriptor).st_size
        self._fsync(descriptor)
        self.kept = length

    def revive(self) -> None:
        """Start the next process, which has no fault unless kills are repeated."""
        self.dead = False
        dies = self.fault == AGAIN and self.kills < LIVES
        self.at = self.writes + self._random.randrange(LIFE) if dies else -1

    def _lose_sectors(self, stream: Stream) -> None:
        end = stream.tell()
        for first in range(self.kept - self.kept % SECTOR, end, SECTOR):
            if self._random.random() < 0.5:  # noqa: PLR2004 - each sector written or not
                low, high = max(first, self.kept), min(first + SECTOR, end)
                stream.seek(low)
                stream.raw(bytes(high - low))
        stream.seek(end)


class Stream:
    """Open file of a journal, which writes through a `Disk`."""

    def __init__(self, file: FileIO, disk: Disk) -> None:
        self._file, self._disk = file, disk
        self.tell, self.seek, self.truncate = file.tell, file.seek, file.truncate
        self.fileno, self.close = file.fileno, file.close

    @property
    def closed(self) -> bool:
        """Whether the file is closed."""
        return self._file.closed

    def write(self, line: bytes) -> int:
        """Write through the disk."""
        return self._disk.write(self, line)

    def raw(self, line: bytes) -> int:
        """Write to the file without faults."""
        return int(self._file.write(line))


@contextmanager
def below_the_journal(disk: Disk) -> Iterator[None]:
    """Insert a simulated disk below every journal that is opened."""
    begin = Journal.__init__
    append = Journal.append
    close = Journal.close

    def __init__(journal, path, clock, *, stream, records, synced=True):  # type: ignore[no-untyped-def] # noqa: ANN001, ANN202, N807
        begin(journal, path, clock, stream=Stream(stream, disk), records=records, synced=synced)  # type: ignore[arg-type]

    def appending(journal, kind, **data):  # type: ignore[no-untyped-def] # noqa: ANN001, ANN003, ANN202
        if disk.fault in GONE and disk.writes == disk.at and not disk.struck:
            disk.struck = True
            take_away(journal.path, disk.fault)
        return append(journal, kind, **data)

    def closing(journal: Journal) -> None:
        if not disk.dead:
            close(journal)
        else:
            journal._close_file()  # noqa: SLF001 - the system closes files of dead processes

    with (
        mock.patch.object(Journal, "__init__", __init__),
        mock.patch.object(Journal, "append", appending),
        mock.patch.object(Journal, "close", closing),
        mock.patch.object(os, "fsync", disk.fsync),
        mock.patch.object(journal_module, "_tell_on_standard_error"),
    ):
        yield


def take_away(path: Path, how: str) -> None:
    """Remove or rename an open journal, or the folder of its data set."""
    dataset = path.parents[2]
    elsewhere = {"renamed": path, "folder renamed": dataset}
    if how == "removed":
        path.unlink()
    elif how == "folder removed":
        shutil.rmtree(dataset)
    else:
        elsewhere[how].rename(elsewhere[how].with_name("elsewhere"))
