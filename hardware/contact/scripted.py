"""Read the finger's position from a script file, for demonstrations and tests of textures.

SPEC: ``scripted:FILE``, where FILE is a CSV with the columns ``time_s,x_mm,y_mm``, sorted by time.
Time 0 is the start of each exploration. After the last row, the finger stays at its last position.
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import ClassVar

from slipscale.faults import UserError
from slipscale.hardware.contact.source import POSITION, ContactSource, Sample, Surroundings

COLUMNS = ("time_s", *POSITION)
LAST_S = 0.01  # interval between the samples that repeat the last row


class ScriptedPosition(ContactSource):
    """Finger position read from a script.

    Parameters
    ----------
    surroundings : Surroundings
    way : sequence of Sample
        Positions in order of time, with times since the start of an exploration.
    file : str
        Path of the script file, stored with the data.
    """

    name: ClassVar[str] = "scripted"
    quantities = POSITION
    virtual = True

    def __init__(self, surroundings: Surroundings, way: list[Sample], file: str) -> None:
        self._clock = surroundings.clock
        self._way = way
        self._file = file
        self._begun_s = 0.0
        self._next = 0
        self._told_s = -math.inf

    def connect(self) -> None:
        """Do nothing."""

    def begin(self) -> None:
        """Restart the script."""
        self._begun_s, self._next, self._told_s = self._clock.now(), 0, -math.inf

    def take(self) -> list[Sample]:
        """Return the samples since the last call; when the script has ended, its last position."""
        now_s = self._clock.now()
        due = []
        while self._next < len(self._way):
            time_s, values = self._way[self._next]
            if self._begun_s + time_s > now_s:
                break
            due.append(Sample(self._begun_s + time_s, values))
            self._next += 1
        if self._next == len(self._way) and not due and now_s - self._told_s >= LAST_S:
            due.append(Sample(now_s, self._way[-1].values))
        if due:
            self._told_s = due[-1].time_s
        return due

    def close(self) -> None:
        """Do nothing."""

    def describe(self) -> dict[str, object]:
        """Return the source's name and its script file."""
        return {"name": self.name, "file": self._file, "rows": len(self._way)}


def read_way(path: Path) -> list[Sample]:
    """Read a script file. Raises `UserError` with file and line."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.reader(stream))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UserError(
            "--position scripted: {path} cannot be read ({error})", path=path, error=error
        ) from None
    if not rows or tuple(rows[0]) != COLUMNS:
        raise UserError(
            "--position scripted: {path}, line 1: expected the columns {columns}",
            path=path,
            columns=",".join(COLUMNS),
        )
    way: list[Sample] = []
    for line, row in enumerate(rows[1:], start=2):
        try:
            time_s, *values = map(float, row)
        except ValueError:
            time_s, values = math.nan, []
        after = way[-1].time_s if way else 0.0
        finite = all(math.isfinite(each) for each in (time_s, *values))
        if len(row) != len(COLUMNS) or not finite or time_s < after:
            raise UserError(
                "--position scripted: {path}, line {line}: expected {count} numbers, and a time "
                "of at least {after:g} s",
                path=path,
                line=line,
                count=len(COLUMNS),
                after=after,
            )
        way.append(Sample(time_s, tuple(values)))
    if not way:
        raise UserError("--position scripted: {path}: expected at least one row", path=path)
    return way


def open_position(address: str, surroundings: Surroundings) -> ContactSource:
    """Return the scripted position (entry point ``scripted``). Raises `UserError`."""
    if not address:
        raise UserError("--position scripted: expected scripted:FILE")
    return ScriptedPosition(surroundings, read_way(Path(address)), address)
