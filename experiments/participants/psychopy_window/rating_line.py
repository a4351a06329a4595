"""The screen of a visual analogue scale: a mark on a line, put there by mouse, touch or keys."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.experiments.participants.psychopy_window import scene
from slipscale.experiments.participants.psychopy_window.entry import ENTER
from slipscale.experiments.participants.psychopy_window.scene import Box, Scene, Text
from slipscale.experiments.participants.psychopy_window.screen_texts import (
    ScreenResult,
    go_on_key,
    naming_key,
    remaining,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.experiments.protocols.steps import Ask, VisualAnalogueQuestion

LINE_Y, LINE_LENGTH, LINE_WIDTH = 0.05, 1.1, 0.006
#: How far from the line a click still means it, up and down, and beyond its ends.
NEAR_Y, NEAR_X = 0.09, 0.05
DONE = Box(x=0, y=-0.4, width=1.26, height=0.08, colour="field")


class Marking:
    """A line between two words and the mark on it; the time limit is shown where there is one.

    The answer can be handed in once the mark was put somewhere: where it stands at first is no
    answer.
    """

    single_key = True
    pointed = True

    def __init__(
        self, step: Ask, question: VisualAnalogueQuestion, texts: Mapping[str, str]
    ) -> None:
        self.rejected: list[str] = []
        self._question = question
        self._texts = texts
        self._limit_s = step.time_limit_s
        self._put: float | None = None
        self._notice = ""

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question, the line with its words, the mark, and how to hand it in."""
        question, texts = self._question, self._texts
        half = LINE_LENGTH / 2
        said = (scene.notice(self._notice),) if self._notice else ()
        foot = "window.mark_keys" if self._put is None else "window.mark_done"
        return (
            Text(content=question.prompt.strip(), y=0.25, size=0.06, width=1.2, height=0.17),
            Box(x=0, y=LINE_Y, width=LINE_LENGTH, height=LINE_WIDTH, colour="text"),
            *(
                Box(x=x, y=LINE_Y, width=LINE_WIDTH, height=0.05, colour="text")
                for x in (-half, half)
            ),
            *(
                Text(content=words.strip(), x=x, y=LINE_Y - 0.06, width=0.46, anchor="top")
                for words, x in ((question.left, -half + 0.12), (question.right, half - 0.12))
            ),
            *self._mark(),
            *said,
            *(() if self._put is None else (DONE,)),
            scene.hint(naming_key(texts, foot)),
            *remaining(self._limit_s, elapsed_s, texts, y=0.415),
        )

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """End on the key that goes on, or Enter, when the mark was put somewhere in time."""
        if character.casefold() not in (go_on_key(self._texts), ENTER, "\n"):
            return None
        return self._hand_in(elapsed_s)

    def move(self, notches: int) -> None:
        """Move the mark, from its start at first."""
        self._notice = ""
        question = self._question
        place = question.start if self._put is None else self._put
        self._put = question.nearest(place + notches * question.key_step)

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> ScreenResult | None:
        """Put the mark where it was clicked; a click on what says that it is right hands it in."""
        if abs(y - LINE_Y) <= NEAR_Y and abs(x) <= LINE_LENGTH / 2 + NEAR_X:
            self._notice = ""
            self._put = self._question.nearest(100 * (x / LINE_LENGTH + 0.5))
        elif not dragged and abs(y - DONE.y) <= DONE.height / 2 and abs(x) <= DONE.width / 2:
            return self._hand_in(elapsed_s)
        return None

    def erase(self) -> None:
        """Nothing is typed here."""

    @property
    def typed(self) -> str:
        """Where the mark was put, if it was."""
        return "" if self._put is None else f"{self._put:g}"

    def offer(self, typed: str) -> None:
        """Put the mark where it was before the screen was interrupted."""
        if typed:
            self._put = self._question.nearest(float(typed))

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """End when the time limit is over."""
        if self._limit_s is not None and elapsed_s >= self._limit_s:
            return ScreenResult(timed_out=True)
        return None

    def _hand_in(self, elapsed_s: float) -> ScreenResult | None:
        if self.expire(elapsed_s):
            return None
        if self._put is None:
            self._notice = self._texts["window.mark_missing"]
            return None
        return ScreenResult(value=self._put)

    def _mark(self) -> Scene:
        """Return the mark; nothing before it is put, unless its start is shown."""
        question = self._question
        if self._put is None and not question.start_shown:
            return ()
        place = question.start if self._put is None else self._put
        x = LINE_LENGTH * (place / 100 - 0.5)
        return (Box(x=x, y=LINE_Y, width=0.014, height=0.1, colour="accent"),)
