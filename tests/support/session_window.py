"""A session in a separate process with a real window, and a hand that answers what it shows.

This file is also the program of that process. Its window writes to a file what is on the screen, so
that a key is pressed only after its screen has appeared, however slow the machine is.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self
from unittest import mock

from slipscale import commands
from slipscale.experiments.journal.serialisation import step_record
from slipscale.experiments.participants.base import Watch
from slipscale.experiments.participants.psychopy_window import PsychoPyWindow
from slipscale.experiments.session.mailbox import LiveRequest, post, read_status
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.steps import ParticipantStep

REPORT = "SLIPSCALE_SHOWN"  # environment variable: the file that the window writes
PATIENCE_S = 300.0
LOOK_S = 0.02
SAID = "moins glissé, ça colle à peine où"  # typed where words are asked for


@dataclass(frozen=True, slots=True)
class Shown:
    """What is on the screen.

    Attributes
    ----------
    number : int
        Number of screens that the process has shown, including questions whether to stop.
    step : dict
        Record of the step that is performed.
    texts : tuple of str
        All texts on the screen, including what was typed.
    """

    number: int
    step: dict[str, Any]
    texts: tuple[str, ...]


NOTHING = Shown(0, {}, ())


class ReportingWindow(PsychoPyWindow):
    """A window that writes each change of the screen to a file, after the change is visible."""

    def __enter__(self) -> Self:
        self._step: dict[str, Any] = {}
        self._report = NOTHING
        return super().__enter__()

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Carry out one step."""
        self._step = step_record(step)
        return super().perform(step, watch)

    def _show_first(self, screen: Screen, watch: Watch) -> float:
        onset_s = super()._show_first(screen, watch)
        self._tell(self._report.number + 1)
        return onset_s

    def _show(self, shown: scene.Scene) -> float:
        shown_s = super()._show(shown)
        self._tell(self._report.number)
        return shown_s

    def _tell(self, number: int) -> None:
        texts = tuple(item.content for item in self._shown if isinstance(item, scene.Text))
        report = Shown(number, self._step, texts)
        if report != self._report:
            self._report = report
            path = Path(os.environ[REPORT])
            draft = path.with_suffix(".new")
            draft.write_text(json.dumps(asdict(report)), encoding="utf-8")
            draft.replace(path)


class SessionWindow:
    """A command with a window in a separate process, within a ``with`` block.

    Parameters
    ----------
    *words : str
        The command's arguments: ``run`` or ``resume`` with ``--windowed``.
    folder : Path
        Working directory and home of the process.
    """

    def __init__(self, *words: str, folder: Path) -> None:
        self._report = folder / "shown.json"
        self._report.unlink(missing_ok=True)
        self._answered = 0
        self.process = subprocess.Popen(
            [sys.executable, "-P", __file__, *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=folder,
            env=os.environ | {"HOME": str(folder), REPORT: str(self._report)},
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.kill()

    def kill(self) -> None:
        """Kill the process, if it is still running."""
        self.process.kill()
        self.process.communicate()

    def end(self) -> tuple[int, str, str]:
        """Wait for the end of the process; return its status, output and error output."""
        out, said = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out, said

    def shown(self) -> Shown:
        """Return what is on the screen; the number is 0 before the first screen."""
        try:
            report = json.loads(self._report.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return NOTHING
        return Shown(report["number"], report["step"], tuple(report["texts"]))

    def wait_for(self, reached: Callable[[Shown], bool]) -> bool:
        """Wait until the screen satisfies a condition; return False if the process ends first."""
        end_s = time.monotonic() + PATIENCE_S
        while not reached(self.shown()):
            if self.process.poll() is not None:
                return False
            if time.monotonic() > end_s:
                raise TimeoutError(f"the session did not continue after {self.shown()}")
            time.sleep(LOOK_S)
        return True

    def next_step(self, journal: Path | None = None) -> dict[str, Any] | None:
        """Wait for the next screen; return the record of its step, or None after the last.

        Plate faults of the session that writes ``journal`` are answered with a retry.
        """

        def reached(shown: Shown) -> bool:
            if journal and (status := read_status(journal)) and status.state == "fault":
                post(journal, LiveRequest(token=status.token, what="retry"))
            return shown.number > self._answered and shown.step["type"] != "Feedback"

        if not self.wait_for(reached):
            return None
        shown = self.shown()
        self._answered = shown.number
        return shown.step

    def press(self, *keys: str) -> None:
        """Press and release keys, which have the names of X11."""
        subprocess.run(["xdotool", "key", *keys], check=True)

    def escape(self, *, yes: str = "", no: str = "") -> None:
        """Press Escape, and answer the question whether to stop with the key for yes or no."""
        before = self.shown()
        self.press("Escape")
        self.wait_for(lambda shown: shown.number > before.number)
        self.press(yes or no)
        if no:
            self.wait_for(lambda shown: shown.texts == before.texts)
            self._answered = self.shown().number

    def type_until_shown(self, *keys: str, entry: str) -> None:
        """Press keys, and wait until the screen shows the entry."""
        self.press(*keys)
        self.wait_for(lambda shown: entry in shown.texts)

    def answer(self, step: dict[str, Any]) -> None:
        """Answer a step of the paper's study as a sensible person would."""
        name = step.get("name")
        if name is None:
            self.press("space")
        elif name in ("estimate", "scale_top"):
            self.press("1", "2", "comma", "5", "KP_Enter")
        elif name == "difference_felt":
            self.press("o")
        elif name == "verbal_report":
            # xdotool types accents faithfully only where the layout has keys for them; the server
            # forgets the layout with its last window.
            subprocess.run(["setxkbmap", "fr"], check=True)
            subprocess.run(["xdotool", "type", "--delay", "20", SAID], check=True)
            self.press("Return")
        else:
            self.press("1")

    def until(self, name: str) -> dict[str, Any]:
        """Answer all steps before the question with this name; return its record."""
        while step := self.next_step():
            if step.get("name") == name:
                return step
            self.answer(step)
        raise ValueError(f"the session ended before the question {name}")


if __name__ == "__main__":
    sys.argv[0] = "slipscale"
    with mock.patch("slipscale.experiments.running.lab_session.PsychoPyWindow", ReportingWindow):
        sys.exit(commands.main())
