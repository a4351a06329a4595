"""Read the intact records of a journal, and report damage by line.

`read_records` is used to resume a run, and raises an error if there is any damage. `read_whole` is
used to build data sets; it omits only damaged records. The rules are:

- CR before LF, a byte order mark, blank lines and a repeated last line are no damage: git, mail,
  editors and programs that synchronise folders add them, and the checksums cover the text.
- Records are sorted by number, even if lines were moved in the file.
- If several records have the same number, the record whose hash agrees with its neighbours is used.
- An incomplete end of the file does not count as damage. The end is incomplete if the last line is
  truncated, or contains zero bytes because the disk lost power. If several records were not yet on
  disk, the incomplete end can include earlier lines. The entry `kept` in the "begin" record of each
  question is the number of records that were then on disk.
- A record of kind `DAMAGED` replaces each gap in the numbering, and each record whose hash is
  inconsistent with the previous record.
"""

from __future__ import annotations

from bisect import bisect_left
from codecs import BOM_UTF8
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from slipscale.experiments.journal.record import FORMAT, Record, decode, follows
from slipscale.experiments.journal.serialisation import in_code
from slipscale.faults import UserError
from slipscale.faults.message import Message

# Kind of the placeholder record for one or more unusable records.
DAMAGED = "damaged"


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """Damage to a line of a journal, where lines are numbered from 1."""

    line: int
    reason: str

    def __str__(self) -> str:
        return Message("line {line}: {reason}", line=self.line, reason=self.reason)


@dataclass(slots=True, kw_only=True)
class Reading:
    """The content of a journal.

    Parameters
    ----------
    records : list of Record
        The intact records in order. A single record of kind `DAMAGED` replaces each sequence of
        damaged or missing records.
    damage : list of Damage
        Damaged lines with the reason for each; empty if the journal is intact.
    length : int
        Length of the file in bytes, excluding incomplete records at its end.
    torn : bool
        Whether the end of the file is incomplete, because the machine stopped while writing.
    """

    records: list[Record] = field(default_factory=list)
    damage: list[Damage] = field(default_factory=list)
    length: int = 0
    torn: bool = False

    def mark(self) -> None:
        """Append a record of kind `DAMAGED` in place of one or more unusable records."""
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
    """Return whether a journal contains data. Raises `UserError` if the file cannot be read."""
    try:
        return path.stat().st_size > 0
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise UserError("journal {path}: {reason}", path=path, reason=error.strerror) from None


def read_whole(
    path: Path, most: int | None = None, header: Mapping[str, Any] | None = None
) -> Reading:
    """Return the intact records of a journal, and a list of the damage.

    If ``most`` is given, reading stops after this number of lines. If the journal has no header,
    ``header`` states the quantity of its levels.

    Raises
    ------
    UserError
        If the file cannot be read, or is not a Slipscale journal of the supported format.
    """
    try:
        with path.open("rb") as stream:
            lines = stream.readlines() if most is None else [stream.readline() for _ in range(most)]
    except OSError as error:
        raise UserError("journal {path}: {reason}", path=path, reason=error.strerror) from None
    reading = Reading()
    found: list[_Line] = []
    wrong: list[int] = []  # lines without a record
    sizes = [len(line) for line in lines if line]
    lines = [_as_written(line, place) for place, line in enumerate(lines) if line]
    whole = _before_torn_end(lines)
    reading.torn = whole < len(lines)
    blank = 0  # bytes of blank lines since the last record
    for place, line in enumerate(lines[:whole]):
        if not line.strip():
            blank += sizes[place]
            continue
        try:
            record, covered = decode(line)
        except ValueError as error:
            wrong.append(place)
            reading.damage.append(Damage(line=place + 1, reason=str(error)))
        else:
            if not found and record.number == 0:
                _check_format(path, record)
            found.append(_Line(place, record, covered))
        reading.length += blank + sizes[place]
        blank = 0
    if len(found) > 1 and found[-1][1:] == found[-2][1:]:
        # The last line was repeated. It is no part of the journal, so a resumed run replaces it.
        reading.length -= sizes[found.pop().place]
    chosen = _one_each(found, reading)
    _report_moved(chosen, reading)
    _put_in_order(chosen, wrong, reading)
    reading.damage.sort(key=lambda damage: damage.line)
    if reading.records and reading.records[0].kind == "header":
        header = reading.records[0].data
    named = in_code(header or {})
    reading.records = [replace(each, data=named(each.data)) for each in reading.records]
    return reading


class _Line(NamedTuple):
    """Intact line of a journal: its index in the file (from 0), its record and the hashed text."""

    place: int
    record: Record
    covered: str


def _one_each(found: list[_Line], reading: Reading) -> list[_Line]:
    """Return one line per record number in file order, and report duplicate numbers as damage."""
    of_number: dict[int, list[_Line]] = {}
    for line in found:
        of_number.setdefault(line.record.number, []).append(line)
    at = {line.place: line.record.number for line in found}

    def trust(line: _Line) -> tuple[int, int]:
        """Count the neighbouring records that confirm a line's hash, and its position."""
        number, place = line.record.number, line.place
        before = of_number.get(number - 1, [])
        after = of_number.get(number + 1, [])
        linked = any(follows(line.record, line.covered, each.record.hash) for each in before)
        leads = any(follows(each.record, each.covered, line.record.hash) for each in after)
        beside = (at.get(place - 1) == number - 1) + (at.get(place + 1) == number + 1)
        return linked + leads, beside

    chosen = {
        n: max(each, key=trust) if len(each) > 1 else each[0] for n, each in of_number.items()
    }
    for line in found:
        kept = chosen[line.record.number]
        if kept is not line:
            reason = f"record {line.record.number} is also on line"
            first = kept.place + 1
            reading.damage.append(Damage(line=line.place + 1, reason=f"{reason} {first}: repeated"))
    return [line for line in found if chosen[line.record.number] is line]


def _report_moved(chosen: list[_Line], reading: Reading) -> None:
    """Report all lines that are not part of the longest sequence in numerical order."""
    ends: list[int] = []  # Smallest last number of the increasing sequences of each length.
    lengths = []
    for line in chosen:
        length = bisect_left(ends, line.record.number)
        ends[length : length + 1] = [line.record.number]
        lengths.append(length)
    wanted = len(ends) - 1
    for line, length in zip(reversed(chosen), reversed(lengths), strict=True):
        if length == wanted:
            wanted -= 1
        else:
            reason = f"record {line.record.number} is not in its original position"
            reading.damage.append(Damage(line=line.place + 1, reason=reason))


def _put_in_order(chosen: list[_Line], wrong: list[int], reading: Reading) -> None:
    """Sort the records by number, and mark each gap with a record of kind `DAMAGED`."""
    expected, place = 0, -1
    before: str | None = ""  # the running hash; None (unknown) after a gap
    for line in sorted(chosen, key=lambda line: line.record.number):
        record = line.record
        if missing := record.number - expected:
            before = None
            reading.mark()
            if missing > sum(place < each < line.place for each in wrong):
                reason = (
                    f"expected record {expected}, found {record.number}: one or more were removed"
                )
                reading.damage.append(Damage(line=line.place + 1, reason=reason))
        if before is None or follows(record, line.covered, before):
            reading.records.append(record)
        else:
            reason = "the hash does not match: this record or a previous record was edited"
            reading.damage.append(Damage(line=line.place + 1, reason=reason))
            reading.mark()
        expected, place, before = record.number + 1, line.place, record.hash
    if any(each > place for each in wrong):
        reading.mark()


def _as_written(line: bytes, place: int) -> bytes:
    """Remove what git, mail and editors add: CR before LF, and a byte order mark."""
    if place == 0:
        line = line.removeprefix(BOM_UTF8)
    return line[:-2] + b"\n" if line.endswith(b"\r\n") else line


def read_records(path: Path) -> tuple[list[Record], int]:
    """Return a journal's records and the length of its intact part in bytes.

    An incomplete end of the file is omitted, and is not included in the length.

    Raises
    ------
    UserError
        If the file cannot be read, is not a journal, or is damaged before its end.
    """
    reading = read_whole(path)
    if reading.damage:
        raise damaged(path, reading.damage[0])
    if reading.records and reading.records[0].kind != "header":
        raise _not_a_journal(path)
    return reading.records, reading.length


def damaged(path: Path, damage: Damage) -> UserError:
    """Create the error to be raised for a damaged journal."""
    return UserError(
        "journal {path}, line {line}: damaged or not a journal ({reason}); expected one JSON "
        "record per line, as the session wrote it",
        path=path,
        line=damage.line,
        reason=damage.reason,
    )


def _before_torn_end(lines: list[bytes]) -> int:
    """Return the number of lines before an incomplete end of the file."""
    torn = [place for place, line in enumerate(lines) if line[-1:] != b"\n" or b"\0" in line]
    if not torn or torn[0] == len(lines) - 1:
        return torn[0] if torn else len(lines)
    before, after = _records(lines[: torn[0]]), _records(lines[torn[0] :])
    first_lost = before[-1].number + 1 if before else 0
    if _kept(before) and _kept(after) <= first_lost:
        return torn[0]
    return len(lines) - (torn[-1] == len(lines) - 1)


def _kept(records: list[Record]) -> int:
    """Return the largest entry `kept`, the number of records that were then on disk."""
    kept = [record.data.get("kept") for record in records]
    return max((each for each in kept if isinstance(each, int)), default=0)


def _records(lines: list[bytes]) -> list[Record]:
    """Return the intact records in a list of lines; zero bytes may precede a record."""
    found = []
    for line in lines:
        with suppress(ValueError):
            found.append(decode(line.rpartition(b"\0")[2])[0])
    return found


def _check_format(path: Path, first: Record) -> None:
    if first.kind != "header" or first.data.get("format") != FORMAT:
        raise _not_a_journal(path)


def _not_a_journal(path: Path) -> UserError:
    return UserError(
        "journal {path}: expected a Slipscale journal of format {format}", path=path, format=FORMAT
    )
