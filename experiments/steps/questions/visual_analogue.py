"""Question answered by placing a mark on a line, by mouse, touch or keys."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.questions.base import Question, is_number
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import ENTER
from slipscale.experiments.steps.screens.scene import Box, Scene, Text
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.screens.screen_texts import asked, go_on_key, naming_key, remaining
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value

LINE_Y, LINE_LENGTH, LINE_WIDTH = 0.05, 1.1, 0.006
#: Maximum distance between a click and the line, vertically and beyond the line's ends.
NEAR_Y, NEAR_X = 0.09, 0.05
DONE = Box(x=0, y=-0.4, width=1.26, height=0.08, colour="field")


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualAnalogueQuestion(Question):
    """Question answered by placing a mark on a line; the value is its position from 0 to 100.

    Parameters
    ----------
    prompt : str
        The question.
    left, right : str
        Labels at the left end (0) and the right end (100) of the line.
    resolution, key_step : float
        Distance between adjacent positions of the mark, and its movement per press of an arrow key.
    start : float
        Position of the mark before the first key press.
    start_shown : bool
        Whether the mark is visible (at ``start``) before the first key press or click.
    """

    EXPECTED: ClassVar = "a position on the line, 0 to 100"
    left: str
    right: str
    resolution: float
    key_step: float
    start: float
    start_shown: bool

    def nearest(self, place: float) -> float:
        """Return the position on the line nearest to ``place``, as a multiple of ``resolution``."""
        held = min(max(place, 0.0), 100.0)
        # The result is rounded, so that three steps of 0.1 are exactly 0.3.
        return round(round(held / self.resolution) * self.resolution, 6)

    def fits(self, value: object) -> bool:
        """Return whether a value is a position on the line, a multiple of ``resolution``."""
        return is_number(value) and value == self.nearest(float(str(value)))

    def rehearsed(self, place: float, /) -> Value:
        """Return the position on the line."""
        return self.nearest(100.0 * place)

    def screen(self, texts: Texts, time_limit_s: float | None, _back: bool, /) -> Screen:
        """Return the screen with the line."""
        return Marking(self, texts, time_limit_s)

    def simulated(self, person: SimulatedPerson, _name: str, /) -> Value:
        """Return the person's rating of the last surface."""
        return self.nearest(person.rating(self.start))


class Marking(Screen):
    """Rating screen: a line between two labels with a mark, and a countdown if time is limited.

    The answer can be submitted only after the mark has been set, because the start position is not
    an answer.
    """

    pointed = True

    def __init__(
        self, question: VisualAnalogueQuestion, texts: Texts, time_limit_s: float | None
    ) -> None:
        super().__init__(texts, time_limit_s)
        self._question = question
        self._put: float | None = None
        self._notice = ""

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question, the labelled line, the mark, and how to submit the answer."""
        question, texts = self._question, self.texts
        half = LINE_LENGTH / 2
        notice = (scene.notice(self._notice),) if self._notice else ()
        foot = "window.mark_keys" if self._put is None else "window.mark_done"
        return (
            asked(question.prompt, y=0.25),
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
            *notice,
            *(() if self._put is None else (DONE,)),
            scene.hint(naming_key(texts, foot)),
            *remaining(self.limit_s, elapsed_s, texts, y=0.415),
        )

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Submit the rating on the `go_on` key or Enter, unless the time limit has passed."""
        if character.casefold() not in (go_on_key(self.texts), ENTER, "\n"):
            return None
        return self._hand_in(elapsed_s)

    def move(self, notches: int) -> None:
        """Move the mark by a number of notches, initially from its start position."""
        self._notice = ""
        question = self._question
        place = question.start if self._put is None else self._put
        self._put = question.nearest(place + notches * question.key_step)

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> Reply | None:
        """Set the mark at the clicked position, or submit the answer if the button is clicked."""
        if abs(y - LINE_Y) <= NEAR_Y and abs(x) <= LINE_LENGTH / 2 + NEAR_X:
            self._notice = ""
            self._put = self._question.nearest(100 * (x / LINE_LENGTH + 0.5))
        elif not dragged and abs(y - DONE.y) <= DONE.height / 2 and abs(x) <= DONE.width / 2:
            return self._hand_in(elapsed_s)
        return None

    @property
    def typed(self) -> str:
        """The position of the mark as text, or an empty string if the mark was not set."""
        return "" if self._put is None else f"{self._put:g}"

    def offer(self, typed: str) -> None:
        """Restore the position that the mark had before an interruption."""
        if typed:
            self._put = self._question.nearest(float(typed))

    def _hand_in(self, elapsed_s: float) -> Reply | None:
        if self.expire(elapsed_s):
            return None
        if self._put is None:
            self._notice = self.texts["window.mark_missing"]
            return None
        return Reply(value=self._put)

    def _mark(self) -> Scene:
        """Return the mark, or nothing if the mark is not set and its start position is hidden."""
        question = self._question
        if self._put is None and not question.start_shown:
            return ()
        place = question.start if self._put is None else self._put
        x = LINE_LENGTH * (place / 100 - 0.5)
        return (Box(x=x, y=LINE_Y, width=0.014, height=0.1, colour="accent"),)
