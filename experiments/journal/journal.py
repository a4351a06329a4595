"""The journal: an append-only record of every step and response, on disk before the next step.

One JSON object a line. Each holds its number ``n``, the session's time ``t`` in seconds, what it
is (``kind``) and a checksum ``crc`` of the rest, so that a torn or altered line is noticed:
a torn last line (the machine died while writing) is cut off on resume, anything else is refused.

One writer at a time: the open journal is locked, and the lock goes with the process.
"""

from __future__ import annotations

import json
import os
import zlib
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import portalocker

from faults import UserError

if TYPE_CHECKING:
    from io import FileIO
    from pathlib import Path
    from types import TracebackType

    from hardware.clock import Clock

FORMAT = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Record:
    """One line of a journal."""

    number: int
    time_s: float
    kind: str
    data: dict[str, Any]


def encode(record: Record) -> bytes:
    """Return a record as a line, with its checksum."""
    fields = {"n": record.number, "t": record.time_s, "kind": record.kind, **record.data}
    body = json.dumps(fields, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return f'{body[:-1]},"crc":"{zlib.crc32(body.encode()):08x}"}}\n'.encode()


def decode(line: bytes, number: int) -> Record:
    """Return the record that a line holds.

    Raises
    ------
    ValueError
        The line is not a whole record, its checksum does not fit, or its number is not
        ``number``.
    """
    body, mark, tail = line.decode().rpartition(',"crc":"')
    if not mark or tail[8:] != '"}\n' or f"{zlib.crc32((body + '}').encode()):08x}" != tail[:8]:
        raise ValueError("the checksum does not fit")
    fields = json.loads(body + "}")
    if fields.pop("n") != number:
        raise ValueError(f"expected record {number}")
    return Record(number=number, time_s=fields.pop("t"), kind=fields.pop("kind"), data=fields)


def has_begun(path: Path) -> bool:
    """Return whether a journal holds anything; UserError where that cannot be found out."""
    try:
        return path.stat().st_size > 0
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise UserError(f"journal {path}: {error.strerror}") from None


def is_being_written(path: Path) -> bool:
    """Return whether a session writes a journal now; False where there is none to be seen."""
    try:
        with path.open("rb") as stream:
            portalocker.lock(stream, portalocker.LOCK_SH | portalocker.LOCK_NB)
    except portalocker.LockException:
        return True
    except OSError:
        return False
    return False


def read_records(path: Path, most: int | None = None) -> tuple[list[Record], int]:
    """Return a journal's records and the length in bytes of what is whole.

    A torn last line is left out; the length tells where it begins. With ``most``, no line
    further on is looked at.

    Raises
    ------
    UserError
        The file cannot be read, is not a journal, or is damaged before its end.
    """
    try:
        lines = path.read_bytes().splitlines(keepends=True)[:most]
    except OSError as error:
        raise UserError(f"journal {path}: {error.strerror}") from None
    records: list[Record] = []
    length = 0
    for place, line in enumerate(lines):
        try:
            record = decode(line, place)
        except (ValueError, KeyError) as error:
            if place == len(lines) - 1 and not line.endswith(b"\n"):
                break
            raise UserError(
                f"journal {path}, line {place + 1}: damaged or not a journal ({error}); "
                "expected one record of JSON a line, as the session wrote it"
            ) from None
        records.append(record)
        length += len(line)
    if records and (records[0].kind != "header" or records[0].data.get("format") != FORMAT):
        raise UserError(f"journal {path}: expected a Slipscale journal of format {FORMAT}")
    return records, length


class Journal:
    """A journal open for writing.

    Parameters
    ----------
    path : Path
        The file. `create` makes it, `reopen` continues it.
    clock : Clock
        Dates the records.

    Raises
    ------
    UserError
        The file exists already (`create`), does not (`reopen`), or another session writes it.
    """

    def __init__(self, path: Path, clock: Clock, *, stream: FileIO, records: list[Record]) -> None:
        self.path = path
        self.records = records
        self._clock = clock
        self._stream = stream
        self._unfinished = False  # a record is being written, or a signal came while it was
        try:
            portalocker.lock(stream, portalocker.LOCK_EX | portalocker.LOCK_NB)
        except portalocker.LockException:
            stream.close()
            raise UserError(f"journal {path}: another session is writing it") from None

    @classmethod
    def create(cls, path: Path, clock: Clock) -> Self:
        """Make a new journal; an existing one is never overwritten.

        A file without one whole record (the machine died at the first) holds nothing to keep.
        """
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            stream = path.open("xb", buffering=0)
        except FileExistsError:
            journal = cls.reopen(path, clock)
            if not journal.records:
                return journal
            journal.close()
            raise UserError(
                f"this run exists already: {path}; name another participant, session or run, or "
                "go on with it: slipscale resume"
            ) from None
        except OSError as error:
            raise UserError(f"journal {path}: {error.strerror}") from None
        _sync_folder(path.parent)
        return cls(path, clock, stream=stream, records=[])

    @classmethod
    def reopen(cls, path: Path, clock: Clock) -> Self:
        """Continue an interrupted journal, without its torn last line if it has one."""
        try:
            stream = path.open("r+b", buffering=0)
        except OSError as error:
            raise UserError(f"journal {path}: {error.strerror}") from None
        journal = cls(path, clock, stream=stream, records=[])
        try:
            journal._take_stock()
        except UserError:
            stream.close()
            raise
        return journal

    def write(self, kind: str, **data: Any) -> Record:
        """Append a record and return once it is on disk.

        A signal may end it anywhere; the next record then follows what reached the disk.
        """
        if self._unfinished:
            self._take_stock()
        self._unfinished = True
        number = len(self.records)
        record = Record(number=number, time_s=self._clock.now(), kind=kind, data=data)
        line = encode(record)
        whole = self._stream.tell()
        try:
            # Unbuffered: what a full disk refused must not come again at the next try or the end.
            while line:
                line = line[self._stream.write(line) :]
            os.fsync(self._stream.fileno())
        except OSError as error:
            # A half-written line would make the file unreadable for whatever follows it.
            with suppress(OSError):
                self._cut(whole)
            raise UserError(
                f"journal {self.path}: cannot write ({error.strerror}); "
                "all responses until now are on disk: free some space, then slipscale resume"
            ) from None
        self.records.append(record)
        self._unfinished = False
        return record

    def _take_stock(self) -> None:
        """Find out what reached the disk, and continue after it."""
        self.records[:], length = read_records(self.path)
        self._cut(length)

    def _cut(self, length: int) -> None:
        """Go to the end of what is whole, and cut off the rest."""
        self._stream.truncate(length)
        self._stream.seek(length)
        self._unfinished = False

    def close(self) -> None:
        """Close the file and give up the lock; a journal that never began leaves no file."""
        self._stream.close()
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


def _sync_folder(folder: Path) -> None:
    """Make a new file's name durable, where the system lets a folder be synchronised."""
    if os.name == "posix":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
