"""Question screen with an answer field, which explains why an entry was rejected."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.participants.psychopy_window import entry, scene, touch
from slipscale.experiments.participants.psychopy_window.entry import ERASE
from slipscale.experiments.participants.psychopy_window.scene import Scene, Text
from slipscale.experiments.participants.psychopy_window.screen_texts import remaining
from slipscale.experiments.participants.psychopy_window.waiting import Unmoved, by_touch
from slipscale.experiments.steps.questions import (
    ChoiceQuestion,
    ComparisonQuestion,
    NumberQuestion,
    TextQuestion,
    WholeNumberQuestion,
    YesNoQuestion,
)
from slipscale.experiments.steps.replies import BACK, Reply
from slipscale.experiments.steps.steps import Ask

if TYPE_CHECKING:
    Texts = Mapping[str, str]

CARET = "|"
BACK_Y = -0.46  # vertical position below the hint and the touch keys


class Asking(Unmoved):
    """Screen for a question with an answer field, and a countdown if time is limited."""

    def __init__(self, step: Ask, texts: Texts) -> None:
        question = step.question
        self.rejected: list[str] = []
        self.single_key = isinstance(
            question, YesNoQuestion | ChoiceQuestion | ComparisonQuestion
        ) and not entry.is_long(question)
        self._limit_s = step.time_limit_s
        self._texts = texts
        self._touch = by_touch(texts)
        self._entry = entry.entry_for(question, texts)
        self._notice = ""
        self._back = step.back
        self._prompt = question.prompt.strip()
        self._body: Callable[[], Scene]
        match question:
            case NumberQuestion() | WholeNumberQuestion():
                self._body, self._hint = self._number, texts["window.enter_number"]
            case TextQuestion():
                self._body, self._hint = self._text, texts["window.enter_text"]
            case YesNoQuestion():
                self._body, self._hint = self._yes_no, texts["window.yes_or_no"]
            case ChoiceQuestion():
                self._options = question.options
                if entry.is_long(question):
                    self._body, self._hint = self._list, texts["window.choose_number"]
                else:
                    self._body, self._hint = self._choice, texts["window.choose_key"]
            case ComparisonQuestion():
                self._compared = question.options
                self._body, self._hint = self._comparison, texts["window.choose_key"]
            case _:
                raise TypeError(f"no answer field for {type(question).__name__}")

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question, the entry and, after a rejected entry, the reason."""
        prompt = Text(content=self._prompt, y=0.28, size=0.06, width=1.2, height=0.17)
        left = remaining(self._limit_s, elapsed_s, self._texts, y=0.43)
        return (prompt, *self._body(), *self._foot(), *self._way_back(), *left)

    def _foot(self) -> Scene:
        hint = () if self._touch else (scene.hint(self._hint),)
        if not self._notice:
            return hint
        # Touch keys cover the usual position of the notice, so the notice replaces the hint.
        notice = scene.notice(self._notice)
        return (replace(notice, y=scene.HINT_Y),) if self._touch else (notice, *hint)

    def _way_back(self) -> Scene:
        if not self._back:
            return ()
        if self._touch:
            words = self._texts["window.back_touch"]
            return scene.button(words, ERASE, x=0.0, y=BACK_Y, width=0.5, height=0.06)
        return (replace(scene.hint(self._texts["window.back"]), y=BACK_Y),)

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Process a character. Return the outcome if the character completes the answer in time."""
        if self.expire(elapsed_s):
            return None
        verdict = self._entry.press(character)
        self._notice = ""
        if isinstance(verdict, Reply):
            return verdict
        if verdict:
            self._notice = self._texts[verdict.reason].format(**verdict.blanks)
            if verdict.entry:
                self.rejected.append(verdict.entry)
        return None

    def erase(self) -> Reply | None:
        """Delete the last character. If the field is empty, return to the previous question."""
        self._notice = ""
        if self._back and not self._entry.content:
            return Reply(value=BACK)
        self._entry.erase()
        return None

    def move(self, notches: int) -> None:
        """Move the selection up or down in the list."""
        self._notice = ""
        self._entry.turn(notches)

    @property
    def typed(self) -> str:
        """The contents of the answer field."""
        return self._entry.content

    def offer(self, typed: str) -> None:
        """Restore an interrupted entry, one character at a time."""
        for character in typed:
            self._entry.press(character)

    def expire(self, elapsed_s: float) -> Reply | None:
        """Return a time-out if the time limit has passed."""
        if self._limit_s is not None and elapsed_s >= self._limit_s:
            return Reply(timed_out=True)
        return None

    def _number(self) -> Scene:
        if self._touch:
            return touch.number_pad(self._entry.content, self._texts)
        return (
            scene.Box(x=0, y=0.02, width=1.0, height=0.2, colour="field"),
            Text(content=self._entry.content, y=0.02, size=number_size(self._entry.content),
                 width=2.0, caret=True),
        )  # fmt: skip

    def _text(self) -> Scene:
        return (
            scene.Box(x=0, y=-0.01, width=1.24, height=0.42, colour="field"),
            Text(content=self._entry.content + CARET, y=0.18, size=0.05, width=1.18, height=0.38,
                 anchor="top", align="left"),
        )  # fmt: skip

    def _yes_no(self) -> Scene:
        return self._two_keys("window.yes", "window.no", y=0.02)

    def _two_keys(self, yes: str, no: str, *, y: float) -> Scene:
        texts = self._texts
        keys = (texts["window.yes_key"], texts["window.no_key"])
        return scene.key_row(keys, (texts[yes], texts[no]), y=y, touch=self._touch)

    def _choice(self) -> Scene:
        meanings = tuple(words for _, words in self._options)
        return scene.key_list(meanings, top=0.17, height=0.43, touch=self._touch)

    def _list(self) -> Scene:
        words = tuple(words for _, words in self._options)
        place = self._entry.place if isinstance(self._entry, entry.ListEntry) else None
        return touch.scrolled(words, place, self._entry.content, self._texts)

    def _comparison(self) -> Scene:
        keys = tuple(str(number) for number in range(1, len(self._compared) + 1))
        return scene.key_row(keys, self._compared, y=0.02, touch=self._touch)


class Stopping(Asking):
    """Screen that asks whether the participant pressed Escape intentionally."""

    def __init__(self, texts: Texts) -> None:
        question = YesNoQuestion(prompt=texts["window.stop"])
        super().__init__(Ask(name="stop", question=question), texts)

    def _yes_no(self) -> Scene:
        note = self._texts["window.stop_note"]
        return (
            *self._two_keys("window.stop_yes", "window.stop_no", y=0.06),
            Text(content=note, y=-0.19, size=scene.HINT, colour="quiet"),
        )


def number_size(content: str) -> float:
    """Return the font size at which the digits of an entry fit the field."""
    roomy = 11
    return scene.DIGITS * min(1.0, roomy / max(len(content), 1))
