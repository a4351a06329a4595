"""The campaign of kills and faults: whatever happens to the disk, no answer is lost or changed.

Use: ``make torture`` (a few minutes), ``make torture ARGS="--every 1 --participants 3"`` (long).

A pilot of each study is run undisturbed. Then it is run again and again, each time with another
fault below the journal, at another record; it is resumed as often as it takes, and the data set
that comes out is compared with the undisturbed one, file by file and row by row. The faults are
those of a file layer put under the journal:

- kills: before a record, in the middle of it, after it but before it is on the disk;
- a disk that lost its power: of the last record any sectors are written, the others are zeros;
- errors: EIO, ENOSPC, EROFS at a write or at its end, EIO at ``fsync``;
- short writes: a write that takes a part of the bytes, and no error;
- the file removed, or renamed, in mid-session.

Prints one row for each study and fault. Exit status 1 where one set of data differs.
"""

from __future__ import annotations

import argparse
import errno
import os
import random
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

from experiments.dataset.bids import build_dataset
from experiments.dataset.rendering import render
from experiments.dataset.runs import read_runs
from experiments.dataset.verification import verify
from experiments.journal import journal as journal_module
from experiments.journal.journal import Journal
from experiments.running.pilot import pilot_plans, run_simulated
from experiments.study.file import shipped_studies
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from io import FileIO

    from experiments.dataset.rendering import Content
    from experiments.study.run_plan import RunPlan

EVERY_OPTION = Path(__file__).with_name("every_option.toml")
SECTOR = 512
# The faults, by name: what is done to the bytes of one record.
KILLS = ("kill before", "kill within", "kill after", "power cut")
ERRORS = {
    "EIO": errno.EIO,
    "ENOSPC": errno.ENOSPC,
    "EROFS": errno.EROFS,
}
WITHIN = tuple(f"{name} {place}" for name in ERRORS for place in ("at once", "half way"))
FAULTS = (*KILLS, *WITHIN, "fsync EIO", "short writes", "removed", "renamed")


class Killed(BaseException):
    """The process is dead: nothing that it does reaches the disk any more."""


class Disk:
    """What lies below a journal: does as it is told until the record that a fault is for.

    Parameters
    ----------
    fault : str
        One of `FAULTS`.
    at : int
        The number of the write that fails, from 0; -1 for none.
    """

    def __init__(self, fault: str, at: int) -> None:
        self.fault, self.at = fault, at
        self.writes = 0
        self.dead = False
        self.struck = False
        self._random = random.Random(f"{fault}/{at}")
        self._fsync = os.fsync

    def write(self, stream: Stream, line: bytes) -> int:
        """Write a record, or do with it what the fault is."""
        if self.dead:
            raise Killed
        number, self.writes = self.writes, self.writes + 1
        if number != self.at:
            return stream.raw(line)
        self.struck = True
        half = len(line) // 2
        if self.fault in KILLS:
            self.dead = True
            part = {"kill before": b"", "kill within": line[:half], "kill after": line}
            stream.raw(part[self.fault] if self.fault in part else self._sectors(stream, line))
            raise Killed
        name, _, place = self.fault.partition(" ")
        if name in ERRORS:
            stream.raw(line[:half] if place == "half way" else b"")
            raise OSError(ERRORS[name], os.strerror(ERRORS[name]))
        return stream.raw(line[: max(half, 1)] if self.fault == "short writes" else line)

    def fsync(self, descriptor: int) -> None:
        """Synchronise, or fail to."""
        if self.dead:
            raise Killed
        if self.fault == "fsync EIO" and self.writes == self.at + 1 and not self.struck:
            self.struck = True
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        self._fsync(descriptor)

    def _sectors(self, stream: Stream, line: bytes) -> bytes:
        """Return a record of which some sectors of the disk were not written."""
        start, torn = stream.tell(), bytearray(line)
        end = start + len(line)
        for first in range(start - start % SECTOR, end, SECTOR):
            if self._random.random() < 0.5:  # noqa: PLR2004 - each sector written or not
                low, high = max(first, start), min(first + SECTOR, end)
                torn[low - start : high - start] = bytes(high - low)
        return bytes(torn)


class Stream:
    """The journal's open file, with a `Disk` below it."""

    def __init__(self, file: FileIO, disk: Disk) -> None:
        self._file, self._disk = file, disk
        self.tell, self.seek, self.truncate = file.tell, file.seek, file.truncate
        self.fileno, self.close = file.fileno, file.close

    def write(self, line: bytes) -> int:
        """Write through the disk."""
        return self._disk.write(self, line)

    def raw(self, line: bytes) -> int:
        """Write to the file itself."""
        return int(self._file.write(line))


@contextmanager
def below_the_journal(disk: Disk) -> Iterator[None]:
    """Put a disk below every journal that is opened."""
    begin = Journal.__init__
    write = Journal.write
    close = Journal.close

    def __init__(journal, path, clock, *, stream, records):  # type: ignore[no-untyped-def] # noqa: ANN001, ANN202, N807
        begin(journal, path, clock, stream=Stream(stream, disk), records=records)  # type: ignore[arg-type]

    def writing(journal, kind, **data):  # type: ignore[no-untyped-def] # noqa: ANN001, ANN003, ANN202
        if disk.fault in ("removed", "renamed") and disk.writes == disk.at and not disk.struck:
            disk.struck = True
            take_away(journal.path, disk.fault)
        return write(journal, kind, **data)

    def closing(journal: Journal) -> None:
        if not disk.dead:
            close(journal)
        else:  # a dead process tidies nothing up
            journal._stream.close()  # noqa: SLF001 - the system does this for it

    with (
        mock.patch.object(Journal, "__init__", __init__),
        mock.patch.object(Journal, "write", writing),
        mock.patch.object(Journal, "close", closing),
        mock.patch.object(os, "fsync", disk.fsync),
        mock.patch.object(journal_module, "_tell_on_standard_error"),
    ):
        yield


def take_away(path: Path, how: str) -> None:
    """Remove or rename a journal under its writer."""
    if how == "removed":
        path.unlink()
    else:
        path.rename(path.with_name("elsewhere"))


def content(folder: Path) -> dict[str, Content]:
    """Return all that a data set's journals give, but for what is not the same by design."""
    runs, problems = read_runs(folder)
    files, unfit = render(runs)
    if problems or unfit:
        raise UserError("; ".join(str(problem) for problem in [*problems, *unfit]))
    return {str(name): text for name, text in files.items()}


def disturbed(folder: Path, plan: RunPlan, disk: Disk, kept: list[Path]) -> Path:
    """Run a pilot over a disk, resume it until it is complete; return where its journal is."""
    with (
        below_the_journal(disk),
        mock.patch.object(journal_module, "fallback_folders", return_value=kept),
    ):
        try:
            run_simulated(folder, plan, "mock")
        except (Killed, UserError):
            disk.dead = False
            disk.at = -1
            run_simulated(folder, plan, "mock")
    moved = disk.fault in ("removed", "renamed") and disk.struck
    return kept[0] if moved else folder


def campaign(study: str, every: int, participants: int, tell: Callable[[str], None]) -> int:
    """Do everything to one study's pilot; return in how many cases its data differed."""
    plans = pilot_plans(study, participants=participants, seed=None, language=None)
    counts: Counter[str] = Counter()
    bad: list[str] = []
    shared = Path("/dev/shm")  # noqa: S108 - a disk in memory, where there is one: many writes
    place = shared if shared.is_dir() else None
    for plan in plans:
        with tempfile.TemporaryDirectory(dir=place) as whole:
            undisturbed = Disk("none", -1)
            with below_the_journal(undisturbed):
                run_simulated(Path(whole), plan, "mock")
            expected = content(Path(whole))
        for offset, fault in enumerate(FAULTS):
            for at in range(offset % every, undisturbed.writes, every):
                with tempfile.TemporaryDirectory(dir=place) as made:
                    disk = Disk(fault, at)
                    case = f"{study}, participant {plan.participant}: {fault} at write {at}"
                    try:
                        found = disturbed(Path(made, "a"), plan, disk, [Path(made, "kept")])
                        build_dataset(found)
                        if content(found) != expected or verify(found) or not disk.struck:
                            bad.append(f"{case}: the data differ")
                    except Exception as error:  # noqa: BLE001 - what is looked for
                        bad.append(f"{case}: {error!r}")
                counts[fault] += 1
    for fault in FAULTS:
        wrong = sum(f": {fault} at write" in line for line in bad)
        tell(f"| {Path(study).stem} | {fault} | {counts[fault]} | {wrong} |")
    for line in bad:
        print(line, file=sys.stderr)
    return len(bad)


def main(words: list[str] | None = None) -> int:
    """Run the campaign; return 1 where any data differed."""
    parser = argparse.ArgumentParser(description="kills and disk faults below the journal")
    parser.add_argument(
        "--every", type=int, default=7, metavar="N", help="fail at each N-th record (default: 7)"
    )
    parser.add_argument(
        "--participants", type=int, default=1, metavar="N", help="of each study (default: 1)"
    )
    parser.add_argument(
        "--study", action="append", metavar="STUDY", help="this one (default: all, and one more)"
    )
    args = parser.parse_args(words)
    began_s = time.monotonic()
    print("| study | fault | cases | data lost, doubled or changed |\n| --- | --- | --- | --- |")
    studies = args.study or [*shipped_studies(), str(EVERY_OPTION)]
    wrong = sum(campaign(study, args.every, args.participants, print) for study in studies)
    print(f"\n{wrong} cases with other data; {time.monotonic() - began_s:.0f} s", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
