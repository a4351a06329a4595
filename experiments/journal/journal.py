"""The journal: an append-only record of every step and response.

How a line looks, and what proves it, is `slipscale.experiments.journal.record`; how a journal is
read is `slipscale.experiments.journal.reading`: a torn end (the machine died while writing) is cut
off on resume, anything else that is not whole is refused.

What is on disk when:

- `Journal.append` hands a record to the system and returns: a killed process loses none. A thread
  (`slipscale.experiments.journal.keeper`) takes it to the disk.
- `Journal.wait_for` is the barrier. A session waits there before each question for the last answer,
  and nothing is called kept or saved before. Power cuts lose nothing from before a barrier.
- `Journal.write` does both. Only what a participant's trial must not wait for is appended.
- If the disk fails, the records that it has not confirmed are cut off, and the next call of any
  of these raises: `append`, `wait_for`, `check` (at each frame), `close`.

An interrupted run is resumed by `slipscale.experiments.session.session`, which replays these
records.

One writer at a time: see `slipscale.experiments.journal.locks`. A journal that disappears under its
writer (removed, renamed, its disk unmounted) is written anew, whole, in a fallback folder.
"""

from __future__ import annotations

import errno
import os
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from slipscale.experiments.journal import locks
from slipscale.experiments.journal.keeper import Keeper, Mark
from slipscale.experiments.journal.reading import read_records
from slipscale.experiments.journal.record import Record, chained, encode
from slipscale.experiments.journal.serialisation import QUANTITY, in_um_names
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable
    from io import FileIO
    from types import TracebackType

    from slipscale.hardware.clock import Clock

# The modes of a new file: for its owner alone, or as the system's own choice (umask) has it.
OWNER_ONLY, AS_USUAL = 0o600, 0o666
FALLBACK = "slipscale-kept"
# What helps if a record cannot be written.
REMEDIES = {errno.ENOSPC: "free some space", errno.EDQUOT: "free some of your quota"}
CHECK_DISK = "check the disk and its cable"


class Journal:
    """A journal open for writing.

    Parameters
    ----------
    path : Path
        The file. `create` makes it, `reopen` continues it.
    clock : Clock
        Dates the records.
    synced : bool
        Whether each record waits for the disk. Without it (a pilot, whose answers can be had again)
        a record is handed to the system, so that a killed process loses none and only a power cut
        could, and the disk is waited for once, at the end.

    Raises
    ------
    UserError
        The file exists already (`create`), does not (`reopen`), or another session writes it.

    Attributes
    ----------
    path : Path
        Where it is written now: another place than at first once that has gone.
    clock : Clock
        Dates the records.
    lost : Path or None
        Where it was written at first, if that has gone.
    moved, tell : callable
        Told the new place, and a sentence, when that happens.
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
        self._unfinished = False  # a record is being written, or a signal came while it was
        try:
            locks.take(stream, path)
        except BaseException:  # a signal too: whoever keeps its traceback would keep the lock
            stream.close()
            raise

    @classmethod
    def create(cls, path: Path, clock: Clock, *, private: bool = True, synced: bool = True) -> Self:
        """Make a new journal; an existing one is never overwritten.

        With ``private``, only its owner may read it, where the system knows owners. A file
        without one whole record (the machine died at the first) holds nothing to keep.
        """
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            mode = OWNER_ONLY if private else AS_USUAL
            stream = _new_file(path, mode)
        except FileExistsError:
            journal = cls.reopen(path, clock, synced=synced)
            if not journal.records:
                return journal
            journal.close()
            raise UserError(
                f"this run exists already: {path}; name another participant, session or run, or "
                "go on with it: slipscale resume"
            ) from None
        except OSError as error:
            raise UserError(f"journal {path}: {error.strerror}") from None
        journal = cls(path, clock, stream=stream, records=[], synced=synced)
        try:
            if synced:
                _sync_folder(path.parent)
        except OSError as error:
            journal.close()
            raise UserError(f"journal {path}: {error.strerror}") from None
        return journal

    @classmethod
    def reopen(cls, path: Path, clock: Clock, *, synced: bool = True) -> Self:
        """Continue an interrupted journal, without its torn last line if it has one."""
        try:
            stream = path.open("r+b", buffering=0)
        except OSError as error:
            raise UserError(f"journal {path}: {error.strerror}") from None
        journal = cls(path, clock, stream=stream, records=[], synced=synced)
        try:
            journal._take_stock()
        except BaseException:
            journal._let_go()
            raise
        return journal

    def write(self, kind: str, **data: Any) -> Record:
        """Append a record and return once it is on disk."""
        record = self.append(kind, **data)
        self.wait_for(record.number + 1)
        return record

    def append(self, kind: str, **data: Any) -> Record:
        """Append a record and return once the system has it; a thread takes it to the disk.

        A signal may end it anywhere; the next record then follows what reached the system.
        """
        self.check()
        if self._unfinished:
            self._take_stock()
        if not self._in_place():
            self._move()
        self._unfinished = True
        number = len(self.records)
        header = self.records[0].data if self.records else data
        if QUANTITY not in header:
            data = in_um_names(data)
        record = Record(number=number, time_s=self.clock.now(), kind=kind, data=data)
        record = chained(record, self.records[-1].hash if self.records else "")
        before = self._mark()
        try:
            self._put(encode(record))
        except OSError as error:
            # A half-written line would make the file unreadable for whatever follows it.
            with suppress(OSError):
                self._cut(before.length)
            raise self._not_written(error) from None
        self.records.append(record)
        if self.synced:
            self._keeper = self._keeper or Keeper(self._stream.fileno(), before)
            self._keeper.want(self._mark())
            locks.refresh(self.path)  # nobody waits for a pilot long enough to take it for gone
        self._unfinished = False
        return record

    def wait_for(self, records: int) -> None:
        """Return once so many of the first records are on disk.

        Raises
        ------
        UserError
            The disk failed or does not answer. What it had not confirmed may be lost.
        """
        if keeper := self._keeper:
            if self._unfinished:
                self._take_stock()
            records = min(records, len(self.records))
            if keeper.wanted.records < records:  # a signal came before it was handed over
                keeper.want(self._mark())
            if not keeper.wait(records):
                self._keeper = None  # its thread hangs in the system
                raise self._not_written(OSError(errno.ETIMEDOUT, os.strerror(errno.ETIMEDOUT)))
        self.check()

    def check(self) -> None:
        """Raise `UserError` if the disk has failed since the last call. Cheap."""
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
            f"journal {self.path}: cannot write ({error.strerror}); all responses before the last "
            f"are on disk: {REMEDIES.get(error.errno or 0, CHECK_DISK)}, then slipscale resume"
        )

    def _mark(self) -> Mark:
        return Mark(len(self.records), self._stream.tell())

    def _put(self, line: bytes) -> None:
        """Hand bytes to the system; OSError if it does not take them all."""
        # Unbuffered: what a full disk refused must not come again at the next try or the end.
        while line:
            line = line[self._stream.write(line) :]

    def _in_place(self) -> bool:
        """Return whether the open file is still the one that the path names."""
        if os.name != "posix":  # an open file cannot be removed or renamed there
            return True
        try:
            there = self.path.stat()
            ours = os.fstat(self._stream.fileno())
        except OSError:
            return False
        return ours.st_nlink > 0 and (there.st_dev, there.st_ino) == (ours.st_dev, ours.st_ino)

    def _move(self) -> None:
        """Go on in the fallback folder, with all records until now."""
        gone, self.lost = self.path, self.lost or self.path
        self._close_file()
        for folder in fallback_folders():
            path = folder.joinpath(*gone.parts[-3:])
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                stream = _new_file(path, OWNER_ONLY)
                self._stream, self.path = stream, path
                locks.take(stream, path)
                self._put(b"".join(encode(record) for record in self.records))
                os.fsync(stream.fileno())
                _sync_folder(path.parent)
            except OSError:
                continue
            break
        else:
            raise UserError(
                f"journal {gone}: it has been removed or renamed, or its disk is gone, and no "
                f"other place can be written; {len(self.records)} records were in it"
            )
        self.moved(self.path)
        self.tell(
            f"THE JOURNAL HAS GONE: {gone} was removed or renamed, or its disk is gone. "
            f"All until now and what follows is in {self.path}"
        )

    def _take_stock(self) -> None:
        """Find out what reached the disk, and continue after it."""
        if not self._in_place():
            self._unfinished = False
            return
        self.records[:], length = read_records(self.path)
        self._cut(length)

    def _cut(self, length: int) -> None:
        """Go to the end of what is whole, and cut off the rest."""
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
        """Close the file and give up the lock; a journal that never began leaves no file."""
        try:
            self.wait_for(len(self.records))
            if not self.synced:
                with suppress(OSError):  # what a full disk refused was told at its record
                    os.fsync(self._stream.fileno())
        finally:
            self._let_go()
        if not self.records:
            with suppress(OSError):
                self.path.unlink()
                self.path.parent.rmdir()  # only when it is empty

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def fallback_folders() -> list[Path]:
    """Return where a journal is written whose place has gone, in order: new folders of their own.

    Each has the form of a data set, so that `slipscale resume` and `slipscale data` work there.
    """
    found = []
    for parent in (Path.home() / FALLBACK, Path(tempfile.gettempdir()) / FALLBACK):
        with suppress(OSError):
            parent.mkdir(parents=True, exist_ok=True)
            found.append(Path(tempfile.mkdtemp(prefix="", dir=parent)))
    return found


def _new_file(path: Path, mode: int) -> FileIO:
    """Open a new file for writing, unbuffered; OSError where there is one."""
    return open(path, "xb", buffering=0, opener=lambda name, flags: os.open(name, flags, mode))


def _tell_on_standard_error(sentence: str) -> None:
    print(sentence, file=sys.stderr)


def _sync_folder(folder: Path) -> None:
    """Make a new file's name durable, where the system lets a folder be synchronised."""
    if os.name == "posix":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
