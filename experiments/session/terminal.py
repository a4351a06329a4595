"""The operator's terminal: a few live lines, and keys to pause, void the last trial, retry or stop.

Keys are read without waiting, at every frame of the participant's screen, so the terminal never
holds the session up; a reason for voiding is typed letter by letter while the session continues.
"""

from __future__ import annotations

import codecs
import os
import re
import sys
from collections import deque
from contextlib import ExitStack
from typing import TYPE_CHECKING, Self, TextIO

from rich.live import Live
from rich.text import Text

from experiments.session.operator import Request, SessionStatus

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import TracebackType

    from rich.console import Console

    from experiments.protocols.steps import Trial
    from experiments.session.operator import State

ENTER, ESCAPE, BACKSPACE = "\r\n", "\x1b", "\x7f\b"
# A key: an arrow's or function key's whole sequence, or one character.
KEY = re.compile(r"\x1b[\[O][0-9;]*[A-Za-z~]|.", re.DOTALL)

STATES: dict[State, tuple[str, str]] = {
    "showing": ("screen", "cyan"),
    "presenting": ("presenting", "yellow"),
    "waiting": ("waiting", "green"),
    "paused": ("PAUSED", "bold yellow"),
    "fault": ("FAULT", "bold red"),
    "done": ("done", "bold green"),
}

# What each key asks for, in each state, at once; v asks for a reason first, s whether it was meant.
KEYS: dict[State, dict[str, Request]] = {
    "paused": {"p": Request(what="go_on")},
    "fault": {"r": Request(what="retry")},
    "done": {},
}
RUNNING = {"p": Request(what="pause")}
HELP: dict[State, str] = {
    "paused": "p go on · v void last trial · s stop",
    "fault": "r retry · s stop",
    "done": "",
}
RUNNING_HELP = "p pause · v void last trial · s stop"


def clock_face(seconds: float | None) -> str:
    """Return a duration as minutes and seconds.

    >>> clock_face(125), clock_face(None)
    ('2:05', '–:––')
    """
    if seconds is None:
        return "–:––"
    return f"{int(seconds // 60)}:{int(seconds % 60):02d}"


class TerminalOperator:
    """The operator at a terminal.

    Parameters
    ----------
    console : Console
        Where the lines are shown.
    read_key : callable
        Returns the key that was pressed, or "" at once.
    retries : int
        Faults that are retried without asking: a plug that was touched should not cost a click.
    """

    def __init__(self, console: Console, read_key: Callable[[], str], retries: int = 1) -> None:
        self._console = console
        self._read_key = read_key
        self._retries = retries
        self._status = SessionStatus(state="showing")
        self._reason: str | None = None  # being typed
        self._voiding: Trial | None = None  # the trial that it is about
        self._stopping = False  # asked for, not yet confirmed
        self._live = Live(console=console, auto_refresh=False, transient=False)

    @property
    def busy(self) -> bool:
        """Whether a reason is being typed."""
        return self._reason is not None

    def tell(self, status: SessionStatus) -> None:
        """Show the state."""
        self._status = status
        self._draw()

    def poll(self) -> Request | None:
        """Return what the keys ask for."""
        key = self._read_key()
        state = self._status.state
        if self._reason is not None:
            return self._type(key)
        if state == "fault" and self._retries > 0:
            self._retries -= 1
            return Request(what="retry")
        if self._stopping:
            return self._confirm(key)
        if key == "v" and state not in ("fault", "done"):
            if self._status.voidable is None:
                return Request(what="void")  # the session says why not
            self._reason, self._voiding = "", self._status.voidable
        elif key == "s" and state != "done":
            self._stopping = True
        else:
            return KEYS.get(state, RUNNING).get(key)
        self._draw()
        return None

    def _confirm(self, key: str) -> Request | None:
        """Take the answer to whether to stop: a stray s must not end a session."""
        if not key:
            return None
        self._stopping = False
        self._draw()
        return Request(what="stop") if key == "y" else None

    def _type(self, key: str) -> Request | None:
        """Take a letter of the reason for voiding a trial."""
        reason = self._reason or ""
        if not key:
            return None
        if key in ENTER and reason.strip():
            self._reason = None
            return Request(what="void", reason=reason.strip(), trial=self._voiding)
        if key == ESCAPE:
            self._reason = None
        elif key in BACKSPACE:
            self._reason = reason[:-1]
        elif key.isprintable():
            self._reason = reason + key
        self._draw()
        return None

    def lines(self) -> Text:
        """Return the lines as they stand."""
        status = self._status
        word, style = STATES[status.state]
        text = Text()
        text.append(f" {word:<10} ", style=style)
        if status.trial:
            text.append(f"{status.task}  trial {status.trial} of {status.total}")
        text.append(f"\n  session {status.done} of {status.planned}", style="dim")
        text.append(f"  left {clock_face(status.time_left_s)}", style="dim")
        if status.amplitude_um_pp is not None:
            text.append(f"  {status.amplitude_um_pp:g} µm p-p", style="magenta")
        if status.faults:
            text.append(f"  faults {status.faults}", style="red")
        if status.voided:
            text.append(f"  voided {status.voided}", style="yellow")
        if status.message:
            text.append(f"\n  {status.message}", style=style)
        if self._reason is not None:
            which = self._voiding.number if self._voiding else 0
            text.append(f"\n  void trial {which} because (Enter to void, Esc not to): ", "bold")
            text.append(f"{self._reason}▏")
        elif self._stopping:
            text.append("\n  stop the session? y stops, any other key goes on", "bold")
        else:
            text.append(f"\n  {HELP.get(status.state, RUNNING_HELP)}", style="dim")
        return text

    def _draw(self) -> None:
        self._live.update(self.lines(), refresh=True)

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._live.stop()
        if not self._console.is_terminal:
            self._console.print()  # in a file, Live ends in the middle of a line


class Keys:
    """Single keys from a terminal, without waiting; nothing where there is no terminal."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream: TextIO | None = stream or sys.stdin  # None: a program started without one
        self._stack = ExitStack()
        self._read: Callable[[], str] = lambda: ""

    def __call__(self) -> str:
        """Return the next key, or ""."""
        return self._read()

    def __enter__(self) -> Self:
        if self._stream is not None and self._stream.isatty():
            self._read = self._windows() if os.name == "nt" else self._posix(self._stream.fileno())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def _posix(self, descriptor: int) -> Callable[[], str]:
        # Unix only, as is the next method's msvcrt on Windows.
        import select  # noqa: PLC0415
        import termios  # noqa: PLC0415
        import tty  # noqa: PLC0415

        before = termios.tcgetattr(descriptor)
        # Ctrl-C still interrupts: cbreak leaves the signal keys alone.
        tty.setcbreak(descriptor)
        self._stack.callback(termios.tcsetattr, descriptor, termios.TCSADRAIN, before)

        waiting: deque[str] = deque()
        decoder = codecs.getincrementaldecoder("utf-8")(errors="ignore")

        def read() -> str:
            # Nobody looks here while a surface is being made, so many keys can come at once.
            ready, _, _ = select.select([descriptor], [], [], 0)
            if ready:
                waiting.extend(KEY.findall(decoder.decode(os.read(descriptor, 1024))))
            return waiting.popleft() if waiting else ""

        return read

    def _windows(self) -> Callable[[], str]:
        import msvcrt  # noqa: PLC0415

        kbhit: Callable[[], bool] = msvcrt.kbhit  # type: ignore[attr-defined]  # Windows only
        getwch: Callable[[], str] = msvcrt.getwch  # type: ignore[attr-defined]  # Windows only
        return lambda: getwch() if kbhit() else ""
