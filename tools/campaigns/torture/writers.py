"""Let several processes open one journal at once: one writes, and the others receive an error.

In each round, the writer is killed in the middle of its second record. The next round continues
with the same journal. The campaign runs with and without system locks, which some network drives
do not support.
"""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

from slipscale.experiments.journal import locks
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.reading import read_whole
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from tools.campaigns.torture.pilots import Outcome, folder

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan


WRITERS = 4
KINDS = ("two writers, system locks", "two writers, lock files only")


def writer_campaign(plan: RunPlan, rounds: int, outcome: Outcome) -> None:
    """Run ``rounds`` rounds of writers that race for one journal, for each kind of lock."""
    for kind in KINDS:
        with folder() as dataset:
            path = plan.journal_path(dataset)
            for turn in range(rounds):
                problem = race(path, system_locks=kind == KINDS[0])
                outcome.judge(kind, plan, f"in round {turn}", problem)


def race(path: Path, *, system_locks: bool) -> str:
    """Let several processes open a journal at once, and kill them; describe any problem."""
    before = len(read_whole(path).records) if path.exists() else 0
    start_read, start_write = os.pipe()
    end_read, end_write = os.pipe()
    told_read, told_write = os.pipe()
    children = []
    for _ in range(WRITERS):
        process = os.fork()
        if not process:
            os.close(start_write)
            os.close(end_write)
            _write(path, (start_read, told_write, end_read), system_locks=system_locks)
        children.append(process)
    os.close(start_write)  # all start
    words = ""
    while len(words) < WRITERS:
        words += os.read(told_read, WRITERS).decode()
    for process in children:
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
    for each in (start_read, end_read, end_write, told_read, told_write):
        os.close(each)
    reading = read_whole(path)
    if words.count("w") != 1 or words.count("r") != WRITERS - 1:
        return f"of {WRITERS} writers, {words.count('w')} wrote and {words.count('r')} were refused"
    if reading.damage or len(reading.records) != before + 1:
        return f"{len(reading.records)} of {before + 1} records were read: {reading.damage}"
    return ""


def _write(path: Path, pipes: tuple[int, int, int], *, system_locks: bool) -> None:
    """Open the journal, write one and a half records, and wait to be killed."""
    start, told, end = pipes
    word = b"x"
    try:
        os.read(start, 1)
        without = mock.patch.object(locks, "_lock", return_value=None)
        if not system_locks:
            without.start()
        journal = Journal.reopen(path, VirtualClock()) if path.exists() else None
        journal = journal or Journal.create(path, VirtualClock())
        journal.write("header" if not journal.records else "note", format=2)
        journal._stream.write(b'{"n":')  # noqa: SLF001 - torn, as a kill leaves it
        word = b"w"
    except UserError:
        word = b"r"
    finally:
        os.write(told, word)
        os.read(end, 1)
        os._exit(0)
