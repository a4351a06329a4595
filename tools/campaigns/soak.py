"""Simulate a laboratory's day in one process: sessions on the emulated board, one after another.

Usage: ``make soak`` (200 sessions), ``make soak ARGS="--hours 8 --write"``.

The following must not grow during the day: this process's memory, open files and threads, the
board process's memory, and the processor time per session. On a shared machine, a session takes
more wall time and, because caches are shared, also more processor time. The time of each session is
therefore divided by the time of a reference calculation directly after it. Prints one line per
tenth of the run. The exit status is 1 if the last tenth exceeds the second (the first one includes
lazy imports).
"""

from __future__ import annotations

import itertools
import json
import sys
import tempfile
import threading
import time
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.running.begin_or_resume import run_plan
from slipscale.experiments.session.operator import UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.steps.steps import Adjust, Ask
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import PlateTimeout
from slipscale.hardware.registry import open_plate
from tests.support.emulator_process import EmulatorProcess
from tests.support.scripted import ScriptedParticipant
from tools.campaigns.torture.pilots import plans_of

if TYPE_CHECKING:
    from slipscale.experiments.steps.trial import Value
    from slipscale.experiments.study.run_plan import RunPlan
    from slipscale.hardware.driver import PlateDriver

# Participants per data set; few, because the data set is rebuilt after each session.
PARTICIPANTS = 12
TENTHS = 10
# Limits for growth from the second tenth of the run to the last.
MEMORY_GROWS, MEMORY_MIB, SLOWER = 1.03, 4.0, 1.25
MIB = 2**20
# Number of attempts to connect, because a board may answer late on a busy machine.
ASKED = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Level:
    """Resources of the process after a tenth of the run, and the duration of its sessions.

    ``relative`` is a session's processor time divided by the time of the reference calculation.
    """

    sessions: int
    memory_mib: float
    board_mib: float
    files: int
    threads: int
    cpu_s: float
    relative: float
    median_s: float
    longest_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Took:
    """Wall time and processor time of a session, and time of the reference calculation."""

    whole_s: float
    cpu_s: float
    same_work_s: float


def same_work() -> None:
    """Run the reference calculation, which takes a few hundredths of a second."""
    records = [{"n": number, "t": number / 7, "kind": "done"} for number in range(300)]
    for _ in range(20):
        records = json.loads(json.dumps(records))


def answer(step: Ask | Adjust) -> Value:
    """Return the first answer to any question."""
    return step.question.rehearsed(0.0) if isinstance(step, Ask) else 30.0


def connected(spec: str, clock: VirtualClock, stack: ExitStack) -> PlateDriver:
    """Return the connected plate; try again if a board does not answer in time."""
    for _ in range(ASKED - 1):
        with suppress(PlateTimeout):
            return stack.enter_context(open_plate(spec, clock=clock))
    return stack.enter_context(open_plate(spec, clock=clock))


def session(dataset: Path, plan: RunPlan, port: str) -> Took:
    """Run one session on the board and build its data set; return its duration."""
    began_s, began_cpu_s = time.monotonic(), time.process_time()
    clock, spec = VirtualClock(), f"serial:{port}"
    with Journal.create(plan.journal_path(dataset), clock) as journal, ExitStack() as stack:
        plate = connected(spec, clock, stack)
        outcome = run_plan(
            plan,
            Setup(
                plate=plate,
                participant=ScriptedParticipant(answer, clock),
                journal=journal,
                clock=clock,
                # On a busy machine, the board may miss a heartbeat and silence the plate.
                operator=UnattendedOperator(retries=1000),
            ),
            spec=spec,
        )
    if outcome != "complete" or build_dataset(dataset):
        raise RuntimeError(f"session of participant {plan.participant}: {outcome}")
    ended_s, ended_cpu_s = time.monotonic(), time.process_time()
    same_work()
    return Took(
        whole_s=ended_s - began_s,
        cpu_s=ended_cpu_s - began_cpu_s,
        same_work_s=time.process_time() - ended_cpu_s,
    )


def level(sessions: int, board: int, took: list[Took]) -> Level:
    """Return the current resources of this process and of the board's process."""
    return Level(
        sessions=sessions,
        memory_mib=_resident_mib("self"),
        board_mib=_resident_mib(str(board)),
        files=sum(1 for _ in Path("/proc/self/fd").iterdir()),
        threads=threading.active_count(),
        cpu_s=median(each.cpu_s for each in took),
        relative=median(each.cpu_s / each.same_work_s for each in took),
        median_s=median(each.whole_s for each in took),
        longest_s=max(each.whole_s for each in took),
    )


def _resident_mib(process: str) -> float:
    pages = Path("/proc", process, "statm").read_text().split()[1]
    return int(pages) * 4096 / MIB


def grown(levels: list[Level]) -> list[str]:
    """Return the resources that grew between the second and the last tenth of the run."""
    before, after = levels[1], levels[-1]
    most_mib = before.memory_mib * MEMORY_GROWS + MEMORY_MIB
    most_board_mib = before.board_mib * MEMORY_GROWS + MEMORY_MIB
    wrong = (
        (after.memory_mib > most_mib, "memory"),
        (after.board_mib > most_board_mib, "the board's memory"),
        (after.files > before.files, "open files"),
        (after.threads > before.threads, "threads"),
        (after.relative > SLOWER * before.relative, "time of a session"),
    )
    return [what for more, what in wrong if more]


def day(sessions: int, seconds: float | None) -> tuple[list[str], list[Level]]:
    """Run sessions up to a number or a time limit; return one level per tenth."""
    began_s, lines, levels = time.monotonic(), list[str](), list[Level]()
    took: list[Took] = []
    plans = plans_of("biet2007", PARTICIPANTS)
    with EmulatorProcess("--noise", "0") as board, tempfile.TemporaryDirectory() as place:
        for number in itertools.count(1):
            dataset = Path(place, f"{(number - 1) // PARTICIPANTS}")
            took.append(session(dataset, plans[(number - 1) % PARTICIPANTS], board.port))
            elapsed_s = time.monotonic() - began_s
            share = elapsed_s / seconds if seconds else number / sessions
            if share * TENTHS >= len(levels) + 1 or share >= 1:
                levels.append(level(number, board.process_id, took))
                lines.append(_line(levels[-1], elapsed_s))
                print(lines[-1], flush=True)
                took = []
            if share >= 1:
                break
    return lines, levels


def _line(found: Level, elapsed_s: float) -> str:
    return (
        f"| {elapsed_s / 3600:.2f} | {found.sessions} | {found.memory_mib:.0f} | "
        f"{found.board_mib:.0f} | {found.files} | {found.threads} | {found.cpu_s:.2f} | "
        f"{found.relative:.1f} | {found.median_s:.2f} | {found.longest_s:.2f} |"
    )


def _sessions(text: str) -> int:
    if int(text) < 2 * TENTHS:
        raise ArgumentTypeError(f"{text}: expected {2 * TENTHS} or more")
    return int(text)


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument("--sessions", type=_sessions, default=200, metavar="N", help="default: 200")
    parser.add_argument("--hours", type=float, metavar="H", help="run sessions for H hours")


def run(args: Namespace) -> tuple[int, str]:
    """Simulate a day; return 1 if the use of any resource grew."""
    heads = (
        *("hours", "sessions", "memory MiB", "board MiB", "files", "threads"),
        *("CPU s", "relative to reference work", "median s", "longest s"),
    )
    head = f"| {' | '.join(heads)} |\n|{' --- |' * len(heads)}"
    print(head, flush=True)
    lines, levels = day(args.sessions, 3600 * args.hours if args.hours else None)
    worse = grown(levels)
    said = f"second and last tenth of the run. Grew: {', '.join(worse) or 'nothing'}."
    print(said, file=sys.stderr)
    return int(bool(worse)), "\n".join([said, "", head, lines[1], lines[-1], ""])
