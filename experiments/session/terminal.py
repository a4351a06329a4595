"""The operator's terminal: live status lines, and keys to pause, void, repeat, retry or stop.

The terminal never delays the session, because keys are polled without blocking on every frame of
the participant's screen. The session continues while the operator types a reason for voiding a
trial.
"""

from __future__ import annotations

import codecs
import os
import re
import sys
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import NamedTuple, Self, TextIO

from rich.console import Console
from rich.live import Live
from rich.text import Text

from slipscale.experiments.session.operator import Request, SessionStatus, State, answer_wanted
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import harmless
from slipscale.hardware.errors import StillVibrating

ENTER, ESCAPE, BACKSPACE = "\r\n", "\x1b", "\x7f\b"
# A key: one character, or the complete escape sequence of an arrow or function key.
KEY = re.compile(r"\x1b[\[O][0-9;]*[A-Za-z~]|.", re.DOTALL)
# A session draws the entry and takes one key per frame, so a pasted text must not grow without end.
LONGEST_ENTRY, READ_B = 2000, 65_536

STATES: dict[State, tuple[str, str]] = {
    "showing": ("screen", "cyan"),
    "presenting": ("presenting", "yellow"),
    "waiting": ("waiting", "green"),
    "paused": ("PAUSED", "bold yellow"),
    "fault": ("FAULT", "bold red"),
    "done": ("done", "bold green"),
}

# Requests of the keys that need no prompt, by session state. The keys v, b, a and s open a prompt.
KEYS: dict[State, dict[str, Request]] = {
    "paused": {"p": Request(what="go_on")},
    "fault": {"r": Request(what="retry")},
    "done": {},
}
RUNNING = {"p": Request(what="pause")}
HELP: dict[State, str] = {
    "paused": "p continue · v void trial · b void previous trial · a ask again · s stop",
    "fault": "r retry · s stop",
    "done": "",
}
RUNNING_HELP = "p pause · v void trial · b void previous trial · a ask again · s stop"


@dataclass(slots=True)
class Prompt:
    """A prompt at which the operator types; Enter submits the entry, Escape cancels it.

    Parameters
    ----------
    label : str
        Text shown to the operator: the expected entry and the effect of the Enter key.
    request : callable
        Converts the entry to a request; returns None if the entry is not valid.
    expected : str
        The expected entry, which is shown after an invalid entry.
    """

    label: str
    request: Callable[[str], Request | None]
    expected: str = ""
    typed: str = ""
    told: str = ""


def void_prompt(trial: Trial) -> Prompt:
    """Return the prompt that asks for a reason for voiding a trial. A reason is required."""

    def request(reason: str) -> Request | None:
        return Request(what="void", reason=reason, trial=trial) if reason else None

    label = f"reason for voiding trial {trial.number} (Enter to void, Esc to cancel)"
    return Prompt(label, request, "expected a reason: it is recorded with the trial")


def stop_prompt() -> Prompt:
    """Return the prompt that asks for an (optional) reason for stopping the session."""
    return Prompt(
        "reason for stopping the session (Enter to stop, Esc to continue)",
        lambda reason: Request(what="stop", reason=reason),
    )


def question_prompt(asked: tuple[Ask, ...]) -> Prompt:
    """Return the prompt that asks for the number of the question to repeat."""

    def request(number: str) -> Request | None:
        known = number.isdecimal() and 1 <= int(number) <= len(asked)
        return Request(what="ask_again", question=asked[int(number) - 1]) if known else None

    listed = ", ".join(f"{number} {ask.name}" for number, ask in enumerate(asked, start=1))
    expected = f"expected a number from 1 to {len(asked)}"
    return Prompt(
        f"question to ask again (number and Enter, Esc to cancel): {listed}", request, expected
    )


def answer_prompt(ask: Ask) -> Prompt:
    """Return the prompt for a verbal report or a decision."""
    return Prompt(
        f"{answer_wanted(ask)} (Enter to submit; Esc to use other keys, then n to return)",
        lambda typed: Request(what="answer", reason=typed) if typed else None,
        "expected an answer",
    )


def clock_face(seconds: float | None) -> str:
    """Return a duration as minutes and seconds.

    >>> clock_face(125), clock_face(None)
    ('2:05', '–:––')
    """
    if seconds is None:
        return "–:––"
    return f"{int(seconds // 60)}:{int(seconds % 60):02d}"


class PromptKey(NamedTuple):
    """A key that opens a prompt.

    Parameters
    ----------
    states : tuple of str
        States of the session in which the key opens the prompt.
    open : callable
        Returns the prompt, or None if there is nothing to enter.
    without : Request or None
        Request that is sent if there is no prompt to open, so that the session reports the reason.
    """

    states: tuple[State, ...]
    open: Callable[[SessionStatus], Prompt | None]
    without: Request | None = None


IN_STEPS: tuple[State, ...] = ("showing", "presenting", "waiting", "paused")
PROMPTS: Mapping[str, PromptKey] = {
    "v": PromptKey(
        IN_STEPS, lambda s: void_prompt(s.voidable) if s.voidable else None, Request(what="void")
    ),
    "b": PromptKey(IN_STEPS, lambda s: void_prompt(s.answered) if s.answered else None),
    "a": PromptKey(
        IN_STEPS, lambda s: question_prompt(s.asked) if s.asked else None, Request(what="ask_again")
    ),
    "s": PromptKey((*IN_STEPS, "fault"), lambda _: stop_prompt()),
    "n": PromptKey(("waiting",), lambda s: answer_prompt(s.answering) if s.answering else None),
}


class TerminalOperator:
    """The operator at a terminal.

    Parameters
    ----------
    console : Console
        Shows the lines.
    read_key : callable
        Returns the pressed key, or "" if no key was pressed, without waiting.
    retries : int
        Number of automatic retries after faults, so that a brief loss of contact needs no action.
        A plate that may still vibrate is not retried, so that the operator can read what to do.
    heading : tuple of str
        Describes the session: participant, study, plate; shown above the state.
    """

    def __init__(
        self,
        console: Console,
        read_key: Callable[[], str],
        retries: int = 1,
        heading: tuple[str, ...] = (),
    ) -> None:
        self._console = console
        self._read_key = read_key
        self._retries = retries
        self._heading = heading
        self._status = SessionStatus(state="showing")
        self._prompt: Prompt | None = None  # the open prompt
        self._answer: Prompt | None = None  # opens when the session waits for an answer
        self._live = Live(console=console, auto_refresh=False, transient=False)

    @property
    def busy(self) -> bool:
        """Whether the operator is typing."""
        return self._prompt is not None

    def tell(self, status: SessionStatus) -> None:
        """Show the session's state; ring the bell once per fault."""
        if self._console.is_terminal and status.state == "fault" != self._status.state:
            self._console.bell()
        if status.answering is not self._status.answering:
            # Another prompt in which the operator is typing is not replaced.
            if self._prompt is self._answer:
                self._prompt = None
            self._answer = answer_prompt(status.answering) if status.answering else None
            self._prompt = self._prompt or self._answer
        self._status = status
        self._draw()

    def poll(self) -> Request | None:
        """Return the request made by the operator's key press, if any."""
        key = self._read_key()
        state = self._status.state
        if self._prompt is not None:
            return self._type(self._prompt, key)
        by_hand = self._status.code == StillVibrating.code
        if state == "fault" and self._retries > 0 and not by_hand:
            self._retries -= 1
            return Request(what="retry")
        if key in PROMPTS and state in PROMPTS[key].states:
            self._prompt = PROMPTS[key].open(self._status)
            if key == "n":
                self._answer = self._prompt
            if self._prompt is None:
                return PROMPTS[key].without
            self._draw()
            return None
        return KEYS.get(state, RUNNING).get(key)

    def _type(self, prompt: Prompt, key: str) -> Request | None:
        """Process a key pressed at the open prompt."""
        if not key:
            return None
        prompt.told = ""
        if key in ENTER:
            request = prompt.request(prompt.typed.strip())
            if request is None:
                prompt.told = prompt.expected
                self._draw()
            if prompt is self._answer:
                prompt.typed = ""  # the prompt stays open, because the answer may be refused
            elif request:
                self._prompt = None
            return request
        if key == ESCAPE:
            self._prompt = None
        elif key in BACKSPACE:
            prompt.typed = prompt.typed[:-1]
        elif len(prompt.typed) == LONGEST_ENTRY:
            prompt.told = f"expected {LONGEST_ENTRY} characters or fewer"
        elif key.isprintable():
            prompt.typed += key
        self._draw()
        return None

    def lines(self) -> Text:
        """Return the current status lines."""
        status = self._status
        word, style = STATES[status.state]
        text = Text()
        if self._heading:
            text.append(f"  {' · '.join(self._heading)}\n", "bold")
        text.append(f" {word:<10} ", style=style)
        if status.trial:
            text.append(f"{status.task}  trial {status.trial} of {status.total}")
        text.append(f"\n  session {status.done} of {status.planned}", style="dim")
        text.append(f"  elapsed {clock_face(status.elapsed_s)}", style="dim")
        text.append(f"  left {clock_face(status.time_left_s)}", style="dim")
        if status.level is not None:
            text.append(f"  {status.level}", style="magenta")
        text.append(f"\n  plate {status.plate}", "red" if status.plate == "lost" else "dim")
        if status.temperature_c is not None:
            text.append(f"  {status.temperature_c:.1f} °C", style="dim")
        text.append(f"  noise {status.noise}", style="dim")
        if status.faults:
            text.append(f"  faults {status.faults}", style="red")
        if status.voided:
            text.append(f"  voided {status.voided}", style="yellow")
        if status.message:
            text.append(f"\n  {harmless(status.message)}", style=style)
        if self._prompt is not None:
            text.append(f"\n  {harmless(self._prompt.label)}: ", "bold")
            text.append(f"{self._prompt.typed}▏")
            if self._prompt.told:
                text.append(f"\n  {self._prompt.told}", "yellow")
        else:
            text.append(f"\n  {HELP.get(status.state, RUNNING_HELP)}", style="dim")
        return text

    def _draw(self) -> None:
        self._live.update(self.lines(), refresh=True)

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._live.stop()
        if not self._console.is_terminal:
            self._console.print()  # when writing to a file, Live ends without a line break


class Keys:
    """Reads single key presses from a terminal, if there is one, without blocking."""

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream: TextIO | None = stream or sys.stdin  # None if there is no standard input
        self._stack = ExitStack()
        self._read: Callable[[], str] = lambda: ""

    def __call__(self) -> str:
        """Return the next key press, or an empty string if there is none."""
        return self._read()

    def __enter__(self) -> Self:
        if self._stream is not None and self._stream.isatty():
            self._read = self._keys(self._stream.fileno())
        return self

    def __exit__(self, *_error: object) -> None:
        self._stack.close()

    def _keys(self, descriptor: int) -> Callable[[], str]:
        # Each system has modules of its own.
        if sys.platform == "win32":
            import msvcrt

            return lambda: msvcrt.getwch() if msvcrt.kbhit() else ""
        import select
        import termios
        import tty

        before = termios.tcgetattr(descriptor)
        # The callback is registered first, because a signal may arrive in the meantime.
        self._stack.callback(termios.tcsetattr, descriptor, termios.TCSADRAIN, before)
        # Ctrl-C still interrupts: cbreak mode leaves the signal keys unchanged.
        tty.setcbreak(descriptor)

        waiting: deque[str] = deque()
        decoder = codecs.getincrementaldecoder("utf-8")(errors="ignore")

        def read() -> str:
            # Keys are not read while a surface is being presented, so presses may be queued.
            ready, _, _ = select.select([descriptor], [], [], 0)
            if ready:
                waiting.extend(KEY.findall(decoder.decode(os.read(descriptor, READ_B))))
            if len(waiting) > LONGEST_ENTRY:  # Nobody pressed these keys one by one.
                waiting.clear()
            return waiting.popleft() if waiting else ""

        return read
