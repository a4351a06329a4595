"""What the console starts: each a process of its own, which outlives the console.

A session's output goes to a file, not to a pipe: whoever writes to the pipe of a console that has
died is ended by it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

from slipscale.faults import UserError, harmless

Kind = Literal["session", "check", "test", "analysis", "pilot"]
KINDS: tuple[Kind, ...] = get_args(Kind)
LONGEST = 20_000  # characters of a job's output that are read
# How a session's last warnings begin; those before its end are in its status.
WARNS = ("NO BACKUP of this run:", "The journal's own place has gone")
STEP = "step: "  # how a command begins a line that says what it does now
LEAST_URGENT = 19  # a session's frames come before what is computed beside it
COMPUTING: frozenset[Kind] = frozenset({"analysis", "pilot"})


@dataclass(slots=True, kw_only=True)
class Job:
    """A process that this console started.

    Parameters
    ----------
    kind : str
        What it does: one of each kind runs at a time.
    about : str
        Whom or what it is about, in words.
    parts : int
        Of how many parts its work consists; 0 where that is not known.
    """

    kind: Kind
    about: str
    process: subprocess.Popen[bytes]
    output: Path
    errors: Path
    parts: int = 0
    began_s: float = field(default_factory=time.time)

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self.process.poll() is None

    @property
    def status(self) -> int | None:
        """Its exit status; None while it runs."""
        return self.process.poll()

    def said(self) -> str:
        """Return what it wrote for programs."""
        return _text(self.output)

    def complained(self) -> str:
        """Return the last line of what it wrote for people."""
        lines = [line for line in self._lines() if not line.startswith(STEP)]
        return lines[-1] if lines else ""

    def warnings(self) -> list[str]:
        """Return the warnings that a session wrote for people."""
        return [line for line in self._lines() if line.startswith(WARNS)]

    def steps(self) -> list[str]:
        """Return the steps that it said it came to, in order."""
        return [line.removeprefix(STEP) for line in self._lines() if line.startswith(STEP)]

    def _lines(self) -> list[str]:
        return [line.strip() for line in _text(self.errors).splitlines() if line.strip()]


class Jobs:
    """The processes that this console started, the last of each kind.

    Parameters
    ----------
    folder : Path
        The laboratory folder: where they run.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._last: dict[Kind, Job] = {}

    def last(self, kind: Kind) -> Job | None:
        """Return the last job of a kind."""
        return self._last.get(kind)

    def start(self, kind: Kind, about: str, *words: str, parts: int = 0) -> Job:
        """Start a slipscale command; one that computes gives way to a session.

        Raises
        ------
        UserError
            One of this kind runs already, or the laboratory folder has gone.
        """
        before = self._last.get(kind)
        if before and before.running:
            raise UserError(f"{before.about}: still at work; wait until it is over")
        place = Path(tempfile.mkdtemp(prefix="slipscale-"))
        output, errors = place / "output.txt", place / "errors.txt"
        try:
            with output.open("wb") as out, errors.open("wb") as err:
                process = subprocess.Popen(  # noqa: S603 - our own command, its words checked
                    [sys.executable, "-P", "-m", "slipscale", *words],
                    cwd=self._folder,
                    stdin=subprocess.DEVNULL,
                    stdout=out,
                    stderr=err,
                    # A Ctrl-C for the console is not meant for a session.
                    start_new_session=True,
                )
        except OSError as error:
            raise UserError(
                f"{self._folder}: {error.strerror}; is the folder still there?"
            ) from None
        self._last[kind] = Job(
            kind=kind, about=about, process=process, output=output, errors=errors, parts=parts
        )
        if kind in COMPUTING and sys.platform != "win32":
            with suppress(OSError):  # it has ended already
                os.setpriority(os.PRIO_PROCESS, process.pid, LEAST_URGENT)
        return self._last[kind]


def _text(path: Path) -> str:
    """Return the end of what a process has written until now."""
    try:
        with path.open("rb") as stream:
            size = stream.seek(0, os.SEEK_END)
            stream.seek(max(size - LONGEST, 0))
            content = stream.read()
    except OSError:
        return ""
    return harmless(content.decode(errors="replace").replace("\r", "\n"))
