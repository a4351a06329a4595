"""A journal, read: what is whole of it, and what is damaged, by line.

`read_records` is for whoever goes on with a run: it takes no damage. `read_whole` is for the data
set: damage in one place costs that place only. The rules:

- A record's place is its number, not its line: lines that were moved are read in their order.
- Of several records with one number the one counts whose hash its neighbours confirm.
- A torn end is no damage: the last line, cut short or with bytes of 0. No record holds one; a disk
  that lost its power leaves them in place of a sector. The end begins earlier if several records
  were on their way to the disk: `kept`, in the "begin" of each question, counts those on disk.
- Numbers that are missing leave one mark; a record that does not follow from the one before it is
  replaced by a mark. Every line that is not as written is reported.
"""

from __future__ import annotations

from bisect import bisect_left
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

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
        Length in bytes of what is whole up to the end: a torn end begins there.
    torn : bool
        Whether the end is torn: the machine stopped while writing it. That is no damage.
    """

    records: list[Record] = field(default_factory=list)
    damage: list[Damage] = field(default_factory=list)
    length: int = 0
    torn: bool = False

    def mark(self) -> None:
        """Leave a mark among the records, where one or more cannot be used."""
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
    reading = Reading()
    found: list[_Line] = []
    wrong: list[int] = []  # lines that hold no record
    lines = [line for line in lines if line]
    whole = _before_torn_end(lines)
    reading.torn = whole < len(lines)
    for place, line in enumerate(lines[:whole]):
        try:
            record, covered = decode(line)
        except ValueError as error:
            wrong.append(place)
            reading.damage.append(Damage(line=place + 1, reason=str(error)))
        else:
            if place == 0 and record.number == 0:
                _check_format(path, record)
            found.append(_Line(place, record, covered))
        reading.length += len(line)
    chosen = _one_each(found, reading)
    _report_moved(chosen, reading)
    _put_in_order(chosen, wrong, reading)
    reading.damage.sort(key=lambda damage: damage.line)
    return reading


class _Line(NamedTuple):
    """A line that is whole: its place in the file from 0, its record, the text its hash covers."""

    place: int
    record: Record
    covered: str


def _one_each(found: list[_Line], reading: Reading) -> list[_Line]:
    """Return one line for each number, in the order of the file; report the others."""
    of_number: dict[int, list[_Line]] = {}
    for line in found:
        of_number.setdefault(line.record.number, []).append(line)
    at = {line.place: line.record.number for line in found}

    def trust(line: _Line) -> tuple[int, int]:
        """Return how many neighbours confirm a line: by their hashes, and by their places."""
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
        if chosen[line.record.number] is not line:
            reason = f"record {line.record.number} stands in line"
            there = chosen[line.record.number].place + 1
            reading.damage.append(
                Damage(line=line.place + 1, reason=f"{reason} {there} too: repeated")
            )
    return [line for line in found if chosen[line.record.number] is line]


def _report_moved(chosen: list[_Line], reading: Reading) -> None:
    """Report the fewest lines whose removal leaves all others in the order of their numbers."""
    ends: list[int] = []  # the lowest number that a rising row of each length can end with
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
            reason = f"record {line.record.number} is not in its place: moved"
            reading.damage.append(Damage(line=line.place + 1, reason=reason))


def _put_in_order(chosen: list[_Line], wrong: list[int], reading: Reading) -> None:
    """Put the records in the order of their numbers, with marks where something is missing."""
    expected, place = 0, -1
    before: str | None = ""  # the running hash; None after a gap: it is not known
    for line in sorted(chosen, key=lambda line: line.record.number):
        record = line.record
        if missing := record.number - expected:
            before = None
            reading.mark()
            if missing > sum(place < each < line.place for each in wrong):
                reason = f"expected record {expected}, found {record.number}: one or more removed"
                reading.damage.append(Damage(line=line.place + 1, reason=reason))
        if before is None or follows(record, line.covered, before):
            reading.records.append(record)
        else:
            reason = "it does not follow from the records before it: edited, or one of them was"
            reading.damage.append(Damage(line=line.place + 1, reason=reason))
            reading.mark()
        expected, place, before = record.number + 1, line.place, record.hash
    if any(each > place for each in wrong):
        reading.mark()


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


def _before_torn_end(lines: list[bytes]) -> int:
    """Return how many lines there are before the end that the machine did not finish."""
    torn = [place for place, line in enumerate(lines) if line[-1:] != b"\n" or b"\0" in line]
    if not torn or torn[0] == len(lines) - 1:
        return torn[0] if torn else len(lines)
    before, after = _records(lines[: torn[0]]), _records(lines[torn[0] :])
    first_lost = before[-1].number + 1 if before else 0
    if _kept(before) and _kept(after) <= first_lost:
        return torn[0]
    return len(lines) - (torn[-1] == len(lines) - 1)


def _kept(records: list[Record]) -> int:
    """Return how many records were on disk, as far as some of them say."""
    said = [record.data.get("kept") for record in records]
    return max((each for each in said if isinstance(each, int)), default=0)


def _records(lines: list[bytes]) -> list[Record]:
    """Return the records that are whole; one may follow an empty sector in the same line."""
    found = []
    for line in lines:
        with suppress(ValueError):
            found.append(decode(line.rpartition(b"\0")[2])[0])
    return found


def _check_format(path: Path, first: Record) -> None:
    if first.kind != "header" or first.data.get("format") != FORMAT:
        raise _not_a_journal(path)


def _not_a_journal(path: Path) -> UserError:
    return UserError(f"journal {path}: expected a Slipscale journal of format {FORMAT}")
