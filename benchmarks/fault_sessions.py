"""Run whole sessions on a randomly failing board; count sessions that hang and wrong rows.

    python benchmarks/fault_sessions.py [--sessions 1000] [--first 0] [--firmware-share 0.5]

Each session presents three amplitudes and two textures over a pseudo-terminal while one to three
faults occur. The session's number determines the faults, and the command and phase at which each
occurs. The simulated participant's estimate depends on the plate's actual output at that moment, so
an estimate that does not match its row was given to another surface. A session counts as

- **hanging** if it has not ended after `HANGS_S`;
- **not begun** if the plate could not be connected (no fault is scheduled by then);
- **given up** if the operator's retries were not enough: it ends with a fault and can be resumed;
- with **wrong attributions** if a row's estimate or readback does not match its surface;
- with a **plate left vibrating** if the output is on after the session has ended.

The exit status is 1 if any session hung, attributed an answer to the wrong surface, lost a row or
left the plate vibrating.
Sessions alternate between the emulated board and the compiled firmware, in the requested
proportion.
"""

from __future__ import annotations

import argparse
import random
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.hardware.clock import SystemClock, VirtualClock
from slipscale.hardware.emulator.response_faults import ANSWER_FAULTS, COMMAND_FAULTS, EMULATED_ONLY
from slipscale.hardware.errors import PlateFault
from tests.support.board_sessions import (
    TEXTURED,
    PatientOperator,
    board_plan,
    due,
    felt,
    rows_of,
    run_on_board,
)
from tests.support.emulator_process import EmulatorProcess
from tests.support.scripted import ScriptedParticipant

if TYPE_CHECKING:
    from slipscale.experiments.participants.base import Watch
    from slipscale.experiments.steps.replies import Reply
    from slipscale.experiments.steps.steps import ParticipantStep

SURFACES = 5

BACK_S = 0.1  # Time until a disconnected board is connected again.
DWELL_S = 0.15  # Time before each step of the participant: a few heartbeats.
HANGS_S = 120.0
ESTIMATE_OFF, READBACK_OFF_UM = 0.1, 0.05
# Approximate number of commands per phase in a session without faults.
COMMANDS = {"present": 5, "play": 4, "read": 25, "silence": 6, "connect": 4}
FAULTS = sorted({*ANSWER_FAULTS, *COMMAND_FAULTS})


class HangsError(Exception):
    """The session did not end within the time limit."""


class Participant(ScriptedParticipant):
    """Participant who waits before each step and estimates ten times the plate's actual output."""

    def __init__(self, board: EmulatorProcess, clock: VirtualClock) -> None:
        super().__init__(lambda _: felt(board), clock, step_s=0.01)

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Call `watch` repeatedly for `DWELL_S`, then perform the step."""
        end_s = time.monotonic() + DWELL_S
        while time.monotonic() < end_s:
            watch()
            time.sleep(0.005)
        return super().perform(step, watch)


@contextmanager
def no_longer_than(limit_s: float) -> Iterator[None]:
    def ends(*_: object) -> None:
        raise HangsError

    before = signal.signal(signal.SIGALRM, ends)
    signal.setitimer(signal.ITIMER_REAL, limit_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def orders(number: int, *, firmware: bool) -> list[str]:
    """Draw the faults of a session, with the phase and command at which each occurs."""
    chance = random.Random(number)
    known = [each for each in FAULTS if not (firmware and each in EMULATED_ONLY)]
    drawn = []
    for _ in range(chance.randint(1, 3)):
        phase = chance.choice(sorted(COMMANDS))
        drawn.append(f"{chance.choice(known)}@{phase}/{chance.randint(1, COMMANDS[phase])}")
    return drawn


def session(board: EmulatorProcess, number: int, faults: list[str], folder: Path) -> str:
    """Run a session, and return its outcome."""
    clock = VirtualClock()
    begun: list[bool] = []

    def connected() -> None:
        begun.append(True)
        for each in faults:
            board.fault(each)

    try:
        with no_longer_than(HANGS_S):
            return run_on_board(
                board, board_plan(TEXTURED, seed=number), folder, Participant(board, clock), clock,
                operator=PatientOperator(BACK_S, SystemClock(), retries=12), connected=connected,
            )  # fmt: skip
    except HangsError:
        return "hanging"
    except PlateFault:
        return "given up" if begun else "not begun"


def is_wrong(row: dict[str, str]) -> bool:
    """Return whether an answered row's estimate or readback does not match its surface."""
    if "n/a" in (row["estimate"], row["amplitude_readback_um_pp"]):
        return False
    estimate, mean_level = due(row["texture"], float(row["amplitude_um_pp"]))
    return (
        abs(float(row["estimate"]) - estimate) > ESTIMATE_OFF + 1e-9
        or abs(float(row["amplitude_readback_um_pp"]) - mean_level) > READBACK_OFF_UM
    )


def one(board: EmulatorProcess, number: int, *, firmware: bool) -> Counter[str]:
    """Run a session, return its counts, and print failures."""
    counts: Counter[str] = Counter(sessions=1)
    faults = orders(number, firmware=firmware)
    with tempfile.TemporaryDirectory(prefix="slipscale-campaign-") as name:
        folder = Path(name)
        outcome = session(board, number, faults, folder)
        counts[outcome] += 1
        rows = [] if outcome == "not begun" else rows_of(folder)
        for journal in folder.glob("sourcedata/sub-01/**/*_journal.jsonl"):
            counts["faults"] += sum(r.kind == "fault" for r in read_plan(journal)[1])
    counts["rows"] += len(rows)
    wrong = [row for row in rows if is_wrong(row)]
    counts["wrong attributions"] += len(wrong)
    counts["rows missing"] += outcome == "complete" and SURFACES - len(rows)
    counts["plates left vibrating"] += board.state()["vibrates"]
    board.no_faults()
    board.back()  # The next session requires a connected board.
    if wrong or outcome != "complete" or counts["plates left vibrating"]:
        print(f"session {number}, {'firmware' if firmware else 'emulated'}: {outcome}, {faults}")
        for row in wrong:
            print(f"  {row}")
    return counts


TOLD = (
    "sessions", "complete", "not begun", "given up", "hanging", "faults", "rows", "rows missing",
    "wrong attributions", "plates left vibrating",
)  # fmt: skip
NEVER = ("hanging", "rows missing", "wrong attributions", "plates left vibrating")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--sessions", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, metavar="NUMBER")
    parser.add_argument("--firmware-share", type=float, default=0.5, metavar="SHARE")
    wanted = parser.parse_args()
    options = ("--back-after", str(BACK_S), "--noise", "0")
    totals = {False: Counter[str](), True: Counter[str]()}
    with ExitStack() as stack:
        boards: dict[bool, EmulatorProcess] = {}
        for number in range(wanted.first, wanted.first + wanted.sessions):
            share = wanted.firmware_share
            firmware = int((number + 1) * share) > int(number * share)
            if firmware not in boards:
                more = ("--firmware",) if firmware else ()
                boards[firmware] = stack.enter_context(EmulatorProcess(*options, *more))
            totals[firmware] += one(boards[firmware], number, firmware=firmware)
    print(f"{'':<24}{'emulated':>10}{'firmware':>10}{'both':>10}")
    for each in TOLD:
        emulated, compiled = totals[False][each], totals[True][each]
        print(f"{each:<24}{emulated:>10}{compiled:>10}{emulated + compiled:>10}")
    return int(any(count[each] for count in totals.values() for each in NEVER))


if __name__ == "__main__":
    raise SystemExit(main())
