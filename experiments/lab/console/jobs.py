"""Start processes for the console.

If the console ends, the jobs in `PIPED` end too; all other processes continue to run. A session
writes its output to a file, because writing to the pipe of a console that has died would end the
session.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from typing import Literal, get_args

from slipscale.faults import UserError, harmless
from slipscale.faults.message import AS_DATA, Message, from_data

Kind = Literal[
    "session",
    "check",
    "test",
    "calibrate",
    "conform",
    "surface",
    "emulator",
    "analysis",
    "rehearsals",
    "pilot",
    "verify",
    "build",
    "export",
    "power",
    "freeze",
    "describe",
    "report",
]
KINDS: tuple[Kind, ...] = get_args(Kind)
LONGEST = 20_000  # number of characters read from the end of a job's output
HOLDING = "slipscale.experiments.lab.console.held"
STEP = "step: "  # prefix of a line in which a command reports its current step
LOOK_S = 0.2
HOLD_S = 5.0  # a job on the plate bench ends if no page has been open for this time
LEAST_URGENT = 19  # priority of background computations, below a running session
# Jobs on the plate bench, which run only while a plate-bench page is open.
HELD: tuple[Kind, ...] = ("calibrate", "conform", "surface")
USING_THE_PLATE: tuple[Kind, ...] = ("session", "check", "test", *HELD)
PIPED: tuple[Kind, ...] = (*HELD, "emulator")  # these jobs end with the console


@dataclass(slots=True, kw_only=True)
class Job:
    """A process that this console started.

    Parameters
    ----------
    kind : str
        The type of job. At most one job of each kind runs at a time.
    about : str
        Name of the job in messages, such as "participant 03" or "the calibration".
    parts : int
        Number of parts of the work; 0 if this number is unknown.
    """

    kind: Kind
    about: str
    process: subprocess.Popen[bytes]
    output: Path
    errors: Path
    parts: int = 0
    began_s: float = field(default_factory=time.time)
    held_s: float = field(default_factory=time.monotonic)
    released: bool = False

    def hold(self) -> None:
        """Record that a plate-bench page is still open, so that its job continues."""
        self.held_s = time.monotonic()

    def type(self, line: str) -> None:
        """Send input to a job on the plate bench; raise `UserError` if the job has ended."""
        try:
            if self.process.stdin:
                self.process.stdin.write(f"{line}\n".encode())
                self.process.stdin.flush()
        except (OSError, ValueError):  # the pipe is broken or closed
            raise UserError("{about} has ended; begin again", about=self.about) from None

    def release(self) -> None:
        """End a plate-bench job by closing its input; the job then switches the plate off."""
        self.released = True
        if self.process.stdin:
            self.process.stdin.close()

    def release_when_left(self) -> None:
        """Wait until the job ends; release it if no page has been open for `HOLD_S` seconds."""
        while self.running and time.monotonic() - self.held_s <= HOLD_S:
            time.sleep(LOOK_S)
        if self.running:
            self.release()

    @property
    def running(self) -> bool:
        """Whether the process is still running."""
        return self.process.poll() is None

    @property
    def status(self) -> int | None:
        """The exit status; None while the process runs."""
        return self.process.poll()

    def said(self) -> str:
        """Return the process's machine-readable output."""
        return _text(self.output)

    def complained(self) -> str:
        """Return why the process ended: its last error message, or the signal or status."""
        if errors := self._messages("error"):
            return errors[-1]
        status = self.status or 0
        if status < 0:
            name = signal.Signals(-status).name
            return Message("the program was stopped from outside (signal {name})", name=name)
        lines = [line for line in self._lines() if not line.startswith((STEP, "{"))]
        return lines[-1] if lines else Message("exit status {status}", status=status)

    def warnings(self) -> list[str]:
        """Return the warnings at the end of a session; its status contains earlier warnings."""
        return self._messages("warning")

    def steps(self) -> list[str]:
        """Return the steps that the process has reported, in order."""
        return [line.removeprefix(STEP) for line in self._lines() if line.startswith(STEP)]

    def _messages(self, kind: str) -> list[str]:
        """Return the messages that the command has written as data (`faults.message.report`)."""
        found = []
        for line in self._lines():
            with suppress(ValueError, KeyError, TypeError):
                found.append(harmless(from_data(json.loads(line)[kind])))
        return found

    def _lines(self) -> list[str]:
        return [line.strip() for line in _text(self.errors).splitlines() if line.strip()]


class Jobs:
    """The most recent process of each kind that this console started.

    Parameters
    ----------
    folder : Path
        The laboratory folder, which is the working directory of the processes.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._last: dict[Kind, Job] = {}

    def last(self, kind: Kind) -> Job | None:
        """Return the last job of a kind."""
        return self._last.get(kind)

    def start(self, kind: Kind, about: str, *words: str, parts: int = 0) -> Job:
        """Start a slipscale command; computations run at a lower priority than a session.

        Raises
        ------
        UserError
            If a job of this kind is already running, or the laboratory folder no longer exists.
        """
        before = self._last.get(kind)
        if before and before.running:
            raise UserError("{about}: still running; wait until it is finished", about=before.about)
        piped = kind in PIPED
        place = Path(tempfile.mkdtemp(prefix="slipscale-"))
        output, errors = place / "output.txt", place / "errors.txt"
        try:
            with output.open("wb") as out, errors.open("wb") as err:
                process = subprocess.Popen(  # noqa: S603 - our own command, with checked arguments
                    [sys.executable, "-P", "-m", HOLDING if piped else "slipscale", *words],
                    cwd=self._folder,
                    stdin=subprocess.PIPE if piped else subprocess.DEVNULL,
                    stdout=out,
                    stderr=err,
                    env=os.environ | {AS_DATA: "1"},
                    # Ctrl-C in the console's terminal must not reach the session.
                    start_new_session=True,
                )
        except OSError as error:
            raise UserError(
                "{folder}: {reason}; is the folder still there?",
                folder=self._folder,
                reason=error.strerror,
            ) from None
        self._last[kind] = Job(
            kind=kind, about=about, process=process, output=output, errors=errors, parts=parts
        )
        if kind in HELD:
            Thread(target=self._last[kind].release_when_left, name=kind, daemon=True).start()
        if kind not in USING_THE_PLATE and sys.platform != "win32":
            with suppress(OSError):  # the process has already ended
                os.setpriority(os.PRIO_PROCESS, process.pid, LEAST_URGENT)
        return self._last[kind]


def _text(path: Path) -> str:
    """Return the most recent part of a process's output."""
    try:
        with path.open("rb") as stream:
            size = stream.seek(0, os.SEEK_END)
            stream.seek(max(size - LONGEST, 0))
            content = stream.read()
    except OSError:
        return ""
    return harmless(content.decode(errors="replace").replace("\r", "\n"))
