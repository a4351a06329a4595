"""Screen for a pointing task with a start and a target, selected by mouse, touch or key."""

from __future__ import annotations

from collections.abc import Mapping

from slipscale.experiments.participants.psychopy_window import scene
from slipscale.experiments.participants.psychopy_window.scene import (
    Box,
    Colour,
    Disc,
    Item,
    Scene,
    Text,
)
from slipscale.experiments.participants.psychopy_window.screen_texts import (
    naming_key,
    remaining,
)
from slipscale.experiments.participants.psychopy_window.waiting import Waiting
from slipscale.experiments.steps.questions import PointingQuestion, Selection
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.steps import Ask

BAR_HEIGHT, CURSOR = 0.4, 0.012


class Pointing(Waiting):
    """Screen for a pointing movement from a start to a target.

    The movement begins when the start is selected, and ends with the next selection. A click or
    touch selects the position at which it occurs. If a sensor measures the finger's position, the
    screen shows this position, and the continue key selects it.
    """

    pointed = True

    def __init__(self, step: Ask, question: PointingQuestion, texts: Mapping[str, str]) -> None:
        super().__init__(texts)
        self._question = question
        self._texts = texts
        self._limit_s = step.time_limit_s
        self._began_s: float | None = None
        self._cursor_mm: tuple[float, float] | None = None

    def scene(self, elapsed_s: float) -> Scene:
        """Return the instruction, start, target and cursor, with the next item highlighted."""
        question, moving = self._question, self._began_s is not None
        start = self._mark(question.start_mm, "quiet" if moving else "accent")
        target = self._mark(question.target_mm, "accent" if moving else "quiet")
        foot = "window.point" if self._cursor_mm is None else "window.point_key"
        return (
            Text(content=question.prompt.strip(), y=0.42, width=1.2, height=0.1),
            start,
            target,
            *self._cursor(),
            scene.hint(naming_key(self._texts, foot)),
            *remaining(self._limit_s, elapsed_s, self._texts, y=0.34),
        )

    def see(self, x_mm: float, y_mm: float) -> None:
        """Move the cursor to the finger's measured position."""
        self._cursor_mm = x_mm, y_mm

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Select the cursor's position if the pressed key is the continue key."""
        if self._cursor_mm is None or super().press(character, elapsed_s) is None:
            return None
        return self._select(*self._cursor_mm, elapsed_s)

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> Reply | None:
        """Select the position at which a click or touch occurs."""
        height_mm = self._question.screen_height_mm
        return None if dragged else self._select(x * height_mm, y * height_mm, elapsed_s)

    def expire(self, elapsed_s: float) -> Reply | None:
        """Return a time-out if the time limit has passed."""
        over = self._limit_s is not None and elapsed_s >= self._limit_s
        return Reply(timed_out=True) if over else None

    def _select(self, x_mm: float, y_mm: float, elapsed_s: float) -> Reply | None:
        """Begin the movement if the start is selected. Any later selection ends the movement."""
        if self.expire(elapsed_s):
            return None
        if self._began_s is not None:
            return Reply(value=Selection(x_mm, y_mm, elapsed_s - self._began_s).value)
        if self._question.holds(self._question.start_mm, x_mm, y_mm):
            self._began_s = elapsed_s
        return None

    def _mark(self, centre_mm: tuple[float, float], colour: Colour) -> Item:
        height_mm = self._question.screen_height_mm
        x, y = (each / height_mm for each in centre_mm)
        size = self._question.width_mm / height_mm
        if self._question.bars:
            return Box(x=x, y=y, width=size, height=BAR_HEIGHT, colour=colour)
        return Disc(x=x, y=y, diameter=size, colour=colour)

    def _cursor(self) -> Scene:
        if self._cursor_mm is None:
            return ()
        x, y = (each / self._question.screen_height_mm for each in self._cursor_mm)
        return (Disc(x=x, y=0.0 if self._question.bars else y, diameter=CURSOR, colour="text"),)
