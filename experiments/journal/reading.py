"""A journal, read: what is whole of it, and what is damaged, by line.

`read_records` is for whoever goes on with a run: it takes no damage. `read_whole` is for the data
set: damage in one place costs that place only.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from slipscale.experiments.journal.record import FORMAT, Record, decode, follows
from slipscale.faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

# Stands in a reading where one record or more cannot be used.
DAMAGED = "damaged"


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """What is wrong with one line of a journal; ``line`` counts from 1."""

    line: int
    reason: str

    def __str__(self) -> str:
        """Return line and reason, as a sentence names them."""
        return f"line {self.line}: {self.reason}"


@dataclass(slots=True, kw_only=True)
class Reading:
    """What a journal holds.

    Parameters
    ----------
    records : list of Record
        The whole records in order. Where one or more are damaged or missing, one record of the
        kind `DAMAGED` stands in their place.
    damage : list of Damage
        Where and why; empty for a whole journal.
    length : int
        Length in bytes of what is whole up to the end: a torn last line begins there.
    torn : bool
        Whether the last line is torn: the machine stopped while writing it. That is no damage.
    """

    records: list[Record] = field(default_factory=list)
    damage: list[Damage] = field(default_factory=list)
    length: int = 0
    torn: bool = False

    def note(self, line: int, reason: str) -> None:
        """Note damage, and leave its mark among the records."""
        self.damage.append(Damage(line=line, reason=reason))
        if not self.records or self.records[-1].kind != DAMAGED:
            last = self.records[-1] if self.records else None
            self.records.append(
                Record(
                    number=last.number + 1 if last else 0,
                    time_s=last.time_s if last else 0.0,
                    kind=DAMAGED,
                    data={},
                )
            )


def has_begun(path: Path) -> bool:
    """Return whether a journal holds anything; UserError where that cannot be found out."""
    try:
        return path.stat().st_size > 0
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise UserError(f"journal {path}: {error.strerror}") from None


def read_whole(path: Path, most: int | None = None) -> Reading:
    """Return what is whole of a journal, and what is not.

    With ``most``, no line further on is looked at.

    Raises
    ------
    UserError
        The file cannot be read, or is a journal of another format.
    """
    try:
        with path.open("rb") as stream:
            lines = stream.readlines() if most is None else [stream.readline() for _ in range(most)]
    except OSError as error:
        raise UserError(f"journal {path}: {error.strerror}") from None
    lines = [line for line in lines if line]
    reading = Reading()
    expected = 0
    before: str | None = ""  # the running hash; None after damage: it is not known
    for place, line in enumerate(lines):
        try:
            record, covered = decode(line)
        except ValueError as error:
            if place == len(lines) - 1 and _is_torn(line):
                reading.torn = True
                break
            reading.note(place + 1, str(error))
            expected, before = expected + 1, None
            reading.length += len(line)
            continue
        if place == 0 and record.number == 0:
            _check_format(path, record)
        reason = _misplaced(record, expected) or (
            "it does not follow from the records before it: edited, or one of them was"
            if before is not None and not follows(record, covered, before)
            else ""
        )
        missing = record.number > expected
        if reason:
            reading.note(place + 1, reason)
        if not reason or missing:
            reading.records.append(record)
        expected = max(expected, record.number + 1)
        before = record.hash
        reading.length += len(line)
    return reading


def read_records(path: Path) -> tuple[list[Record], int]:
    """Return a journal's records and the length in bytes of what is whole.

    A torn last line is left out; the length tells where it begins.

    Raises
    ------
    UserError
        The file cannot be read, is not a journal, or is damaged before its end.
    """
    reading = read_whole(path)
    if reading.damage:
        raise damaged(path, reading.damage[0])
    if reading.records and reading.records[0].kind != "header":
        raise _not_a_journal(path)
    return reading.records, reading.length


def damaged(path: Path, damage: Damage) -> UserError:
    """Return the error that names a journal's damage."""
    return UserError(
        f"journal {path}, line {damage.line}: damaged or not a journal ({damage.reason}); "
        "expected one record of JSON a line, as the session wrote it"
    )


def _is_torn(line: bytes) -> bool:
    """Tell whether a last line is one that the machine did not finish.

    No record holds a byte of 0: a disk that lost its power leaves them where a sector of the last
    record was not written, even when a later one was.
    """
    return not line.endswith(b"\n") or b"\0" in line


def _misplaced(record: Record, expected: int) -> str:
    if record.number == expected:
        return ""
    if record.number < expected:
        return f"expected record {expected}, found {record.number}: repeated or moved"
    return f"expected record {expected}, found {record.number}: one or more removed or moved"


def _check_format(path: Path, first: Record) -> None:
    if first.kind != "header" or first.data.get("format") != FORMAT:
        raise _not_a_journal(path)


def _not_a_journal(path: Path) -> UserError:
    return UserError(f"journal {path}: expected a Slipscale journal of format {FORMAT}")
