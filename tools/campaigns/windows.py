"""Run sessions in real windows, and end their process or display at random points.

Usage: ``make windows``, ``make windows ARGS="--signals 5000 --servers 20"`` (an hour). Requires
Xvfb; nothing appears on the screen.

- Signals: one process repeatedly runs and resumes sessions and receives SIGINT, SIGTERM or SIGHUP
  at a random point: while the window opens, in a frame, in a destructor, while a record is
  written or while the data set is built. The command must return 130 and silence the plate. The
  journal must keep all its records, and the run must be resumable.
- Processes: the same for separate processes, at any point after they install signal handlers.
- Servers: the X server is killed during a session in a separate process, after a random number of
  steps. The session must return 3, write a stop record, remove its lock file and live file, and
  explain how to resume.

Prints problems and counts; the exit status is 1 if there was a problem.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import io
import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from argparse import REMAINDER, SUPPRESS, ArgumentParser, Namespace
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest import mock

from slipscale import commands
from slipscale.experiments.journal import locks
from slipscale.experiments.journal.plan_and_progress import is_complete, read_plan
from slipscale.experiments.journal.reading import read_whole
from slipscale.experiments.participants.psychopy_window.display import import_visual
from slipscale.experiments.participants.psychopy_window.keyboard import Keyboard
from slipscale.experiments.running import begin_or_resume
from slipscale.faults import DONE, INTERRUPTED, RIG_FAULT
from slipscale.hardware import signals
from tools.campaigns.torture.pilots import folder

if TYPE_CHECKING:
    from slipscale.hardware.driver import PlateDriver

STUDY = """name = "signals"
title = "Signals"
amplitudes_um_pp = [0.0, 1.2]
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 3
scale_top = "none"
"""
# Characters that are typed in turn, one every few frames; one of them answers any screen.
TYPED, FRAMES = " 5\r1", 4
LONGEST_S = 0.8  # longest time from the start of a command to the signal
NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
CASES_OF_A_PROCESS = 100  # limited, because PsychoPy does not release windows fully
PATIENCE_S = 600.0


@contextmanager
def display() -> Iterator[subprocess.Popen[bytes]]:
    """Run an X server, and set DISPLAY to it."""
    reading, writing = os.pipe()
    words = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(words, pass_fds=[writing], **quiet) as server:  # type: ignore[call-overload]
        os.close(writing)
        with os.fdopen(reading) as answer:
            number = answer.readline().strip()
        with mock.patch.dict(os.environ, {"DISPLAY": f":{number}"}):
            try:
                yield server
            finally:
                server.kill()


def words_for(place: Path, number: int) -> tuple[list[str], Path]:
    """Return the command that begins or resumes a participant's run."""
    label = f"{number:02d}"
    journal = place / f"sourcedata/sub-{label}/sub-{label}_run-01_journal.jsonl"
    if journal.exists() and read_whole(journal).records:
        return ["resume", str(journal), "--windowed"], journal
    study = str(place / "signals.toml")
    run = ["run", study, "--participant", label, "--plate", "mock", "--windowed"]
    return [*run, "--out", str(place)], journal


def judge(journal: Path, before: list[str], status: int | None, said: str) -> str:
    """Return what went wrong after a signal; empty if nothing did."""
    if status != INTERRUPTED:
        return f"status {status}: {said[-400:]}"
    if _tracebacks(said):
        return said[-800:]
    # A dead process's lock file is harmless: the signal came while it was being made.
    if locks.is_being_written(journal):
        return "the run is still locked"
    if list(journal.parent.glob("*.live")):
        return "its mailbox is left"
    return _lost(journal, before)


def _tracebacks(said: str) -> int:
    """Count tracebacks, except those of interrupted destructors."""
    return said.count("Traceback") - said.count("Exception ignored in")


def _lost(journal: Path, before: list[str]) -> str:
    if not journal.exists() or not journal.stat().st_size:
        return "the journal is gone" if before else ""
    _, records = read_plan(journal)  # raises an error if the run cannot be resumed
    now = [record.hash for record in records]
    return "" if now[: len(before)] == before else "records were lost or changed"


def signal_cases(count: int, seed: int) -> dict[str, Any]:
    """Interrupt ``count`` sessions in this process with signals; return counts and problems."""
    chance = random.Random(seed)
    counts: Counter[str] = Counter()
    bad: list[str] = []
    plates: list[PlateDriver] = []
    opened = begin_or_resume.plate_for
    inside = [False]

    def plate_for(*words: Any) -> PlateDriver:
        plates.append(opened(*words))
        return plates[-1]

    def end(number: int, _frame: object) -> None:
        if inside[0]:
            raise signals.note_signal(number)

    for name in NAMES:
        signal.signal(getattr(signal, name), end)
    with (
        folder() as place,
        mock.patch.dict(os.environ, {"HOME": str(place)}),
        mock.patch("slipscale.experiments.running.lab_session.plate_for", plate_for),
        mock.patch.object(Keyboard, "poll", typing(Keyboard.poll)),
    ):
        (place / "signals.toml").write_text(STUDY, encoding="utf-8")
        import_visual()  # a partial import would affect the next case
        for name in ("hardware.plate_file", "hardware.calibration.stored"):
            importlib.import_module(f"slipscale.{name}")
        number = 1
        while sum(counts.values()) < count:
            words, journal = words_for(place, number)
            before = (
                [record.hash for record in read_whole(journal).records] if journal.exists() else []
            )
            name = chance.choice(NAMES)
            delay_s = chance.uniform(0.0, LONGEST_S)
            kill = threading.Timer(delay_s, os.kill, (os.getpid(), getattr(signal, name)))
            said = io.StringIO()
            with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
                kill.start()
                inside[0] = True
                status = ended(words)
                inside[0] = False
            kill.cancel()
            kill.join()
            # The end of a process would close its files and invalidate its lock file.
            gc.collect()
            locks.release(journal)
            signals._Noted.name = ""  # noqa: SLF001
            complete = journal.exists() and _is_over(journal)
            number += complete
            if status == DONE and complete:
                continue  # The session ended before the signal.
            problem = judge(journal, before, status, said.getvalue())
            if not problem and plates and _moves(plates[-1]):
                problem = "the plate vibrates"
            counts[words[0]] += 1
            if problem:
                bad.append(f"{name} after {delay_s:.3f} s of {words[0]}: {problem}")
            plates.clear()
    return {"counts": counts, "bad": bad}


def ended(words: list[str]) -> int:
    """Run a command that a signal may interrupt, and return its exit status."""
    try:
        return commands.main(words)
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception:
        # After a signal, any exception counts as an interruption, as in `commands.main`.
        if not signals._Noted.name:  # noqa: SLF001
            raise
        return INTERRUPTED


def typing(poll: Callable[[Keyboard], list[Any]]) -> Callable[[Keyboard], list[Any]]:
    """Wrap a keyboard's poll so that a character is typed before it every few frames."""
    frames = [0]

    def typed(keyboard: Keyboard) -> list[Any]:
        frames[0] += 1
        place, rest = divmod(frames[0], FRAMES)
        if not rest:
            keyboard._handle.dispatch_event("on_text", TYPED[place % len(TYPED)])  # noqa: SLF001
        return poll(keyboard)

    return typed


def _is_over(journal: Path) -> bool:
    return is_complete(read_whole(journal).records)


def _moves(plate: PlateDriver) -> bool:
    return plate.twin.drive.target_um_pp not in (None, 0.0)  # type: ignore[attr-defined]


def process_case(chance: random.Random, *, server: bool) -> str:
    """Run a session in a separate process; end it or its display at a random point."""
    with folder() as place, display() as xvfb:
        (place / "signals.toml").write_text(STUDY, encoding="utf-8")
        words, journal = words_for(place, 1)
        typed = [sys.executable, "-m", "tools.campaigns", "windows", "--session"]
        command = typed if server else [str(Path(sys.executable).with_name("slipscale"))]
        process = subprocess.Popen(
            [*command, *words],
            env=os.environ | {"HOME": str(place), "PYTHONFAULTHANDLER": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        began_s = time.monotonic()
        if server:
            steps = chance.randrange(1, 12)
            while _begun(journal) < steps and time.monotonic() - began_s < PATIENCE_S:
                time.sleep(0.005)
            time.sleep(chance.uniform(0.0, 0.05))
            xvfb.kill()
        else:
            while not _listens(process.pid):
                time.sleep(0.001)
            time.sleep(chance.uniform(0.0, 6.0))
            process.send_signal(getattr(signal, chance.choice(NAMES)))
        try:
            out, said = process.communicate(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGABRT)  # Python prints all tracebacks
            return f"it hung: {process.communicate()[1][:3000]}"
        if server:
            return _of_server(journal, process.returncode, out + said)
        return judge(journal, [], process.returncode, out + said)


def _listens(process: int) -> bool:
    """Return whether a process has reached the command's first line and installed its handlers."""
    status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    caught = int(status.partition("SigCgt:")[2].split()[0], 16)
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def _begun(journal: Path) -> int:
    return journal.read_bytes().count(b'"kind":"begin"') if journal.exists() else 0


def _of_server(journal: Path, status: int, said: str) -> str:
    if status != RIG_FAULT or _tracebacks(said) or "To continue: slipscale resume" not in said:
        return f"status {status}: {said[-400:]}"
    left = [path.name for path in journal.parent.glob("*.l*") if path != journal]
    last = read_plan(journal)[1][-1].kind
    return f"left behind: {left}" if left else ("" if last == "stop" else f"ends with {last}")


def session(words: list[str]) -> int:
    """Run a command with simulated typing."""
    sys.argv = ["slipscale", *words]
    with mock.patch.object(Keyboard, "poll", typing(Keyboard.poll)):
        return commands.main()


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument("--signals", type=int, default=20, metavar="N", help="number of signals")
    parser.add_argument("--processes", type=int, default=3, metavar="N", help="number of processes")
    parser.add_argument("--servers", type=int, default=3, metavar="N", help="number of X servers")
    parser.add_argument("--seed", type=int, default=1, help="random seed")
    parser.add_argument("--cases", type=int, metavar="N", help=SUPPRESS)
    parser.add_argument("--session", nargs=REMAINDER, help=SUPPRESS)


def run(args: Namespace) -> tuple[int, str]:
    """Run the campaign; return 1 if anything went wrong."""
    if args.session:
        return session(args.session), ""
    if args.cases:
        with display() as server:
            print(json.dumps(signal_cases(args.cases, args.seed)), flush=True)
            server.kill()
            os._exit(DONE)  # libraries close windows at exit, on a display that no longer exists
    # nohup and background shells ignore some signals, and child processes would inherit this.
    for name in NAMES:
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    counts, bad = signals_elsewhere(args.signals, args.seed)
    chance = random.Random(args.seed)
    for what, count in (("processes", args.processes), ("servers", args.servers)):
        for number in range(count):
            counts[what] += 1
            if problem := process_case(chance, server=what == "servers"):
                bad.append(f"{what} {number}: {problem}")
                print(bad[-1], file=sys.stderr)
    text = ", ".join(f"{count:,} {what}" for what, count in counts.items()) + f": {len(bad)} bad"
    print(text)
    return int(bool(bad)), text


def signals_elsewhere(count: int, seed: int) -> tuple[Counter[str], list[str]]:
    """Run the signal cases in subprocesses, one after another."""
    counts: Counter[str] = Counter()
    bad: list[str] = []
    while (left := count - sum(counts.values())) > 0:
        cases = str(min(left, CASES_OF_A_PROCESS))
        words = ["--cases", cases, "--seed", str(seed + sum(counts.values()))]
        done = subprocess.run(
            [sys.executable, "-m", "tools.campaigns", "windows", *words],
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise RuntimeError(f"the process of a campaign failed: {done.stderr[-2000:]}")
        found = json.loads(done.stdout.splitlines()[-1])
        counts.update(found["counts"])
        bad += found["bad"]
        for sentence in found["bad"]:
            print(sentence, file=sys.stderr)
        print(f"{sum(counts.values()):,} of {count:,}: {len(bad)} bad", file=sys.stderr, flush=True)
    return counts, bad
