"""The journal: an append-only record of every step and response.

`slipscale.experiments.journal.record` defines the format of a line and its checksums.
`slipscale.experiments.journal.reading` reads journals. When a run is resumed, an incomplete end of
the file (left by a crash during writing) is removed. All other damage is an error.

The rules for flushing data to disk are:

- `Journal.append` passes a record to the operating system and returns. If the process is killed, no
  record is lost. A thread (`slipscale.experiments.journal.keeper`) then flushes the record to disk.
- Before each question, a session calls `Journal.wait_for` to wait until the last answer is on disk.
  Nothing written before a call to `wait_for` is lost in a power failure.
- `Journal.write` combines `append` and `wait_for`. For records that must not delay a trial, only
  `append` is called.
- If the disk fails, unconfirmed records are removed from the file. The next call to `append`,
  `wait_for`, `close` or `check` (which a session calls on every frame) then raises an error.

`slipscale.experiments.session.session` resumes an interrupted run by replaying these records.

A journal has one writer at a time; see `slipscale.experiments.journal.locks`. If a journal
disappears during a session (for example because its disk is disconnected), all its records are
written to a fallback folder.
"""

from __future__ import annotations

import errno
import os
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from io import FileIO
from pathlib import Path
from typing import Any, Self, cast

from slipscale.experiments.journal import locks
from slipscale.experiments.journal.keeper import Keeper, Mark
from slipscale.experiments.journal.reading import read_records
from slipscale.experiments.journal.record import Record, encode, sealed
from slipscale.experiments.journal.serialisation import in_file
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware.clock import Clock

# Permissions of a new file: readable by its owner only, or determined by the system's umask.
OWNER_ONLY, AS_USUAL = 0o600, 0o666
FALLBACK = "slipscale-kept"
# What to do if a record cannot be written.
REMEDIES = {errno.ENOSPC: "free some space", errno.EDQUOT: "free some of your quota"}
CHECK_DISK = "check the disk and its cable"


class Journal:
    """A journal that is open for writing.

    Parameters
    ----------
    path : Path
        The journal file.
    clock : Clock
        Provides the records' times.
    synced : bool
        Whether each record is flushed to disk. If False, the journal is flushed to disk only when
        it is closed. A power failure may then lose records, but a killed process loses none.
        Pilots are not synced, because they can be repeated.

    Raises
    ------
    UserError
        If `create` finds an existing journal, if `reopen` finds none, or if another session is
        writing to the journal.

    Attributes
    ----------
    path : Path
        The current journal file. The path changes if the original location becomes unavailable.
    clock : Clock
        Provides the records' times.
    lost : Path or None
        Original path, if the file is no longer available there.
    moved, tell : callable
        Functions that are called when the journal moves to another folder: `moved` receives the new
        path, and `tell` receives a message.
    """

    def __init__(
        self,
        path: Path,
        clock: Clock,
        *,
        stream: FileIO,
        records: list[Record],
        synced: bool = True,
    ) -> None:
        self.path = path
        self.synced = synced
        self.records = records
        self.lost: Path | None = None
        self.moved: Callable[[Path], None] = lambda _: None
        self.tell: Callable[[str], None] = _tell_on_standard_error
        self.clock = clock
        self._stream = stream
        self._keeper: Keeper | None = None
        self._in_file: Callable[[Any], Any] | None = None
        self._unfinished = False  # a record is being written, or was interrupted by a signal

    @classmethod
    def create(cls, path: Path, clock: Clock, *, private: bool = True, synced: bool = True) -> Self:
        """Create a new journal without overwriting an existing one.

        If ``private`` is True and the system supports file permissions, only the owner can read the
        file. An existing file may be replaced if it does not contain a complete record, because the
        machine stopped while writing the first one.
        """
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            _new_file(path, OWNER_ONLY if private else AS_USUAL).close()
            if synced:
                _sync_folder(path.parent)
        except FileExistsError:
            pass
        except OSError as error:
            raise UserError("journal {path}: {reason}", path=path, reason=error.strerror) from None
        return cls._open(path, clock, synced=synced, empty=True)

    @classmethod
    def reopen(cls, path: Path, clock: Clock, *, synced: bool = True) -> Self:
        """Continue an interrupted journal after removing incomplete records at its end."""
        return cls._open(path, clock, synced=synced, empty=False)

    @classmethod
    def _open(cls, path: Path, clock: Clock, *, synced: bool, empty: bool) -> Self:
        """Open, lock and read a journal; close it again after an error or a signal."""
        locked = False
        try:
            stream = path.open("r+b", buffering=0)
        except OSError as error:
            raise UserError("journal {path}: {reason}", path=path, reason=error.strerror) from None
        try:
            locks.take(stream, path)
            locked = True
            journal = cls(path, clock, stream=stream, records=[], synced=synced)
            journal._take_stock()
            if empty and journal.records:
                raise UserError(  # noqa: TRY301 - closed below
                    "this run already exists: {path}; name another participant, session or run, "
                    "or resume it: slipscale resume",
                    path=path,
                )
            return journal  # noqa: TRY300 - a signal can arrive before an `else`
        except BaseException:  # Includes signals, because a stored traceback would keep the lock.
            if locked:
                locks.release(path)
            stream.close()
            raise

    def write(self, kind: str, **data: object) -> Record:
        """Append a record, and return when it is on disk."""
        record = self.append(kind, **data)
        self.wait_for(record.number + 1)
        return record

    def append(self, kind: str, **data: object) -> Record:
        """Append a record, and return when the operating system has received it.

        A signal may interrupt this call at any point. The next call then continues the file after
        its last complete record.
        """
        self.check()
        if self._unfinished:
            self._take_stock()
        if not self._in_place():
            self._move()
        self._unfinished = True
        number = len(self.records)
        record = Record(number=number, time_s=self.clock.now(), kind=kind, data=data)
        before = self.records[-1].hash if self.records else ""
        written, line = sealed(replace(record, data=self.in_file(data)), before)
        record = replace(record, hash=written.hash)
        mark = self._mark()
        try:
            self._put(line)
        except OSError as error:
            # A partial line would make all following lines unreadable.
            with suppress(OSError):
                self._cut(mark.length)
            raise self._not_written(error) from None
        self.records.append(record)
        if self.synced:
            self._keeper = self._keeper or Keeper(self._stream.fileno(), mark)
            self._keeper.want(self._mark())
            locks.refresh(self.path)  # unsynced pilots end before their locks expire
        self._unfinished = False
        return record

    def in_file(self, data: dict[str, Any]) -> dict[str, Any]:
        """Rename the keys of a record's data as in the file, whose header states the quantity."""
        if self._in_file is None:
            self._in_file = in_file(self.records[0].data if self.records else data)
        return cast("dict[str, Any]", self._in_file(data))

    def wait_for(self, records: int) -> None:
        """Wait until the first ``records`` records are on disk.

        Raises
        ------
        UserError
            If the disk failed or does not respond. Records that are not yet on disk may be lost.
        """
        if keeper := self._keeper:
            if self._unfinished:
                self._take_stock()
            records = min(records, len(self.records))
            if keeper.wanted.records < records:  # A signal interrupted `append`.
                keeper.want(self._mark())
            if not keeper.wait(records):
                self._keeper = None  # the thread hangs in a system call
                raise self._not_written(OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT)))
        self.check()

    def check(self) -> None:
        """Raise `UserError` if the disk has failed since the last call. This check is fast."""
        keeper = self._keeper
        if keeper is None or keeper.failure is None:
            return
        self._keeper = None
        if not isinstance(keeper.failure, OSError):
            self._unfinished = True
            raise keeper.failure
        del self.records[keeper.kept.records :]
        with suppress(OSError):
            self._cut(keeper.kept.length)
        raise self._not_written(keeper.failure)

    def _not_written(self, error: OSError) -> UserError:
        return UserError(
            "journal {path}: cannot write ({reason}); all responses before the last are on disk: "
            "{remedy}, then slipscale resume",
            path=self.path,
            reason=error.strerror,
            remedy=REMEDIES.get(error.errno or 0, CHECK_DISK),
        )

    def _mark(self) -> Mark:
        return Mark(len(self.records), self._stream.tell())

    def _put(self, line: bytes) -> None:
        """Pass bytes to the operating system; raise OSError if it does not accept all of them."""
        # Unbuffered, because bytes that a full disk rejected must not be written on the next
        # attempt.
        while line:
            line = line[self._stream.write(line) :]

    def _in_place(self) -> bool:
        """Return whether the path still refers to the open file."""
        if os.name != "posix":  # Windows does not remove or rename open files
            return True
        try:
            status = self.path.stat()
            ours = os.fstat(self._stream.fileno())
        except OSError:
            return False
        return ours.st_nlink > 0 and (status.st_dev, status.st_ino) == (ours.st_dev, ours.st_ino)

    def _move(self) -> None:
        """Copy all records so far to a fallback folder, and continue in that folder."""
        lost, self.lost = self.path, self.lost or self.path
        self._close_file()
        for folder in fallback_folders():
            path = folder.joinpath(*lost.parts[-3:])
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                stream = _new_file(path, OWNER_ONLY)
                self._stream, self.path = stream, path
                locks.take(stream, path)
                self._put(
                    b"".join(
                        encode(replace(record, data=self.in_file(record.data)))
                        for record in self.records
                    )
                )
                os.fsync(stream.fileno())
                _sync_folder(path.parent)
            except OSError:
                continue
            break
        else:
            raise UserError(
                "journal {lost} was removed or renamed, or its disk was disconnected, and no "
                "fallback folder can be written; it had {count} records",
                lost=lost,
                count=len(self.records),
            )
        self.moved(self.path)
        self.tell(
            Message(
                "THE JOURNAL IS MISSING: {lost} was removed or renamed, or its disk was "
                "disconnected. All records, past and future, are kept in {path}",
                lost=lost,
                path=self.path,
            )
        )

    def _take_stock(self) -> None:
        """Determine which records are on disk, and continue writing after the last of them."""
        if not self._in_place():
            self._unfinished = False
            return
        try:
            self.records[:], length = read_records(self.path)
            self._cut(length)
        except OSError as error:
            raise self._not_written(error) from None

    def _cut(self, length: int) -> None:
        """Truncate the file after its intact part, and continue writing there."""
        self._stream.truncate(length)
        self._stream.seek(length)
        self._unfinished = False

    def _close_file(self) -> None:
        keeper, self._keeper = self._keeper, None
        try:
            if keeper:
                keeper.stop()
        finally:
            self._stream.close()

    def _let_go(self) -> None:
        try:
            self._close_file()
        finally:
            locks.release(self.path)

    def close(self) -> None:
        """Close the file and release the lock; remove the file if no record was written.

        Closing a journal again has no effect.
        """
        if self._stream.closed:
            return
        try:
            self.wait_for(len(self.records))
            if not self.synced:
                with suppress(OSError):  # a full disk was reported earlier
                    os.fsync(self._stream.fileno())
        finally:
            self._let_go()
        if not self.records:
            with suppress(OSError):
                self.path.unlink()
                self.path.parent.rmdir()  # removes the folder only if it is empty

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()


def fallback_folders() -> list[Path]:
    """Create fallback folders for a journal whose location is missing; return the best one first.

    Each folder has the structure of a data set, so `slipscale resume` and `slipscale data` can read
    it.
    """
    found = []
    for parent in (Path.home() / FALLBACK, Path(tempfile.gettempdir()) / FALLBACK):
        with suppress(OSError):
            parent.mkdir(parents=True, exist_ok=True)
            found.append(Path(tempfile.mkdtemp(prefix="", dir=parent)))
    return found


def _new_file(path: Path, mode: int) -> FileIO:
    """Create a file for unbuffered writing, or raise OSError if it already exists."""
    return open(path, "xb", buffering=0, opener=lambda name, flags: os.open(name, flags, mode))


def _tell_on_standard_error(sentence: str) -> None:
    print(sentence, file=sys.stderr)


def _sync_folder(folder: Path) -> None:
    """Flush the directory entry of a new file to disk, if the system supports this."""
    if os.name == "posix":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
