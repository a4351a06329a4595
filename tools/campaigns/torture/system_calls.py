"""Kill a run with SIGKILL between any two of the system calls that write its files.

Each case is a separate process (a fork, which needs no new imports). The process counts its system
calls for the journal, the lock file and the tables, and kills itself before a given one. The run is
then resumed, and its data set is compared with the uninterrupted one.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.running.pilot import run_simulated
from tools.campaigns.torture.disk_faults import Stream
from tools.campaigns.torture.pilots import Outcome, difference, folder, spread, undisturbed

if TYPE_CHECKING:
    from slipscale.experiments.study.run_plan import RunPlan

FIRST, RESUMED = "in a run", "in a resumed run"
KINDS = (FIRST, RESUMED)
# Python's audit events of calls that name or lock a file.
EVENTS = ("open", "os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.utime")
LOCKS = ("fcntl.flock", "fcntl.fcntl")
NEVER = -1
# A record takes about five calls, so there are more places for kills than for record faults.
CALLS = 4


class Calls:
    """Counts a process's system calls on one folder, and kills the process before one of them.

    An instance also serves as the `Disk` of a `Stream`. Functions remain patched, because the
    process is a fork.
    """

    def __init__(self, root: Path, at: int) -> None:
        self._root = str(root)
        self._at = at
        self.count = 0

    def call(self) -> None:
        """Kill the process if the chosen call is next; otherwise, count the call."""
        if self.count == self._at:
            os.kill(os.getpid(), signal.SIGKILL)
        self.count += 1

    def write(self, stream: Stream, line: bytes) -> int:
        """Write a record in two calls, so that the process can be killed between them."""
        half = len(line) // 2
        self.call()
        stream.raw(line[:half])
        self.call()
        return half + stream.raw(line[half:])

    def watch(self) -> None:
        """Start counting."""
        sys.addaudithook(self._told)
        for name in ("stat", "fstat", "fsync"):
            setattr(os, name, self._counted(getattr(os, name)))
        begin, write = Journal.__init__, Path.write_bytes

        def __init__(journal, path, clock, *, stream, records, synced=True):  # type: ignore[no-untyped-def] # noqa: ANN001, ANN202, N807
            below = Stream(stream, self)  # type: ignore[arg-type]
            below.truncate = self._counted(below.truncate)
            begin(journal, path, clock, stream=below, records=records, synced=synced)  # type: ignore[arg-type]

        def write_bytes(path: Path, data: bytes) -> int:
            write(path, data[: len(data) // 2])
            self.call()
            return write(path, data)

        Journal.__init__ = __init__  # type: ignore[method-assign]
        Path.write_bytes = write_bytes  # type: ignore[method-assign, assignment]

    def _told(self, event: str, arguments: tuple[Any, ...]) -> None:
        # While a folder tree is being removed, its paths are relative to an open folder.
        if event in LOCKS or (
            event in EVENTS
            and (str(arguments[0]).startswith(self._root) or arguments[-1] not in (-1, None))
        ):
            self.call()

    def _counted(self, call: Callable[..., Any]) -> Callable[..., Any]:
        def counted(*arguments: Any, **options: Any) -> Any:
            known = not arguments or isinstance(arguments[0], int)
            if known or str(arguments[0]).startswith(self._root):
                self.call()
            return call(*arguments, **options)

        return counted


@dataclass(frozen=True)
class Strike:
    """What happens at a system call of a process.

    Parameters
    ----------
    name : str
        Name in the table of results.
    begin : callable
        Receives the folder and the number of the call, starts counting, and returns a function that
        returns the number of calls so far.
    raises : tuple of type
        Exceptions with which the process may report what happened.
    """

    name: str
    begin: Callable[[Path, int], Callable[[], int]]
    raises: tuple[type[BaseException], ...] = ()


def _kill(root: Path, at: int) -> Callable[[], int]:
    calls = Calls(root, at)
    calls.watch()
    return lambda: calls.count


SIGKILL = Strike("SIGKILL", _kill)


def in_a_process(
    root: Path, at: int, action: Callable[[], object], strike: Strike = SIGKILL
) -> int | None:
    """Run an action in a fork; return its number of calls, or None if it was struck."""
    reading, writing = os.pipe()
    process = os.fork()
    if not process:
        status = 1
        try:
            count = strike.begin(root, at)
            with suppress(*strike.raises):
                action()
            os.write(writing, str(count()).encode())
            status = 0
        except BaseException:  # noqa: BLE001 - a fork must not go on as its parent
            traceback.print_exc()
        finally:
            os._exit(status)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        told = pipe.read()
    _, status = os.waitpid(process, 0)
    if os.WIFSIGNALED(status):
        return None
    if status:
        raise RuntimeError(f"the process failed, but not by {strike.name} at call {at}")
    return None if -1 < at < int(told) else int(told)


def _run_and_build(dataset: Path, plan: RunPlan) -> None:
    run_simulated(dataset, plan, "mock", synced=True)
    build_dataset(dataset)


def cut(whole: Path, dataset: Path, plan: RunPlan) -> None:
    """Make a data set from a journal torn in the middle of the run and of a record."""
    path = plan.journal_path(dataset)
    path.parent.mkdir(parents=True)
    journal = plan.journal_path(whole).read_bytes()
    path.write_bytes(journal[: len(journal) // 2])


def strike_campaign(plan: RunPlan, places: int, outcome: Outcome, strike: Strike = SIGKILL) -> None:
    """Strike a pilot at ``CALLS * places`` system calls, in a new run and in a resumed run."""
    expected, _ = undisturbed(plan)
    with folder() as place:
        whole, base = place / "whole", place / "base"
        all_calls = in_a_process(whole, NEVER, partial(_run_and_build, whole, plan), strike)
        cut(whole, base, plan)
        for turn, kind in enumerate(KINDS):
            calls = all_calls
            if kind == RESUMED:
                calls = _resumed_calls(base, place / "r", plan, strike)
            for at in spread(calls or 0, CALLS * places, turn):
                made = place / "a"
                if kind == RESUMED:
                    shutil.copytree(base, made)
                try:
                    made_calls = in_a_process(made, at, partial(_run_and_build, made, plan), strike)
                    run_simulated(made, plan, "mock", synced=True)
                    problem = difference(made, expected)
                except Exception as error:  # noqa: BLE001 - any exception is a problem
                    problem, made_calls = repr(error), None
                # One wait for the disk covers several records, so the number of calls varies.
                if problem or made_calls is None:
                    outcome.judge(f"{strike.name} {kind}", plan, f"at call {at}", problem)
                shutil.rmtree(made, ignore_errors=True)


def _resumed_calls(base: Path, dataset: Path, plan: RunPlan, strike: Strike) -> int | None:
    shutil.copytree(base, dataset)
    return in_a_process(dataset, NEVER, partial(_run_and_build, dataset, plan), strike)
