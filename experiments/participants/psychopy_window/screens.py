"""How each step behaves on the screen: a table from step to screen, no window, no clock.

A screen is told of keys and of the time that passed since it was shown, and says what to show and
when it is over. The time is an argument everywhere, so a screen can be tested without waiting.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Protocol

from experiments.participants.psychopy_window import entry, scene, touch
from experiments.participants.psychopy_window.marking import Marking
from experiments.participants.psychopy_window.scene import Scene, Text
from experiments.participants.psychopy_window.screen_words import (
    ScreenResult,
    go_on_key,
    naming_key,
    remaining,
)
from experiments.protocols.steps import (
    FEEL_AGAIN,
    Adjust,
    Ask,
    ChoiceQuestion,
    ComparisonQuestion,
    Explore,
    Feedback,
    Instruct,
    NumberQuestion,
    ParticipantStep,
    Rest,
    TextQuestion,
    VisualAnalogueQuestion,
    WholeNumberQuestion,
    YesNoQuestion,
)

Texts = Mapping[str, str]
CARET = "|"


class Screen(Protocol):
    """One screen.

    ``single_key`` says that a key held from before could end it by mistake, ``pointed`` that the
    mouse is needed.
    """

    single_key: bool
    pointed: bool
    rejected: list[str]

    def scene(self, elapsed_s: float) -> Scene:
        """Return what to show ``elapsed_s`` after the screen came up."""

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """Take a character; return the outcome if it ended the screen."""

    def erase(self) -> None:
        """Take back the last character."""

    def move(self, notches: int) -> None:
        """Move what is moved by keys with arrows or the wheel, to the right and up."""

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> ScreenResult | None:
        """Take a click or touch at a place of the scene; return the outcome if it ended that."""

    @property
    def typed(self) -> str:
        """What has been typed and not handed in."""

    def offer(self, typed: str) -> None:
        """Show what was typed already, before the screen was interrupted."""

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """Return the outcome if the time alone ended the screen."""


class Unmoved:
    """What screens share on which nothing is moved and nothing is pointed at."""

    pointed = False

    def move(self, notches: int) -> None:
        """Nothing is moved here."""

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> None:
        """Nothing is pointed at here."""


class Waiting(Unmoved):
    """What the screens that wait for the key that goes on share: the space bar, as a rule."""

    single_key = True
    typed = ""

    def __init__(
        self, texts: Texts, minimum_s: float = 0.0, maximum_s: float | None = None
    ) -> None:
        self.rejected: list[str] = []
        self._go_on = go_on_key(texts)
        self._minimum_s = minimum_s
        self._maximum_s = maximum_s

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """End on the key that goes on, at the earliest after the minimum."""
        if character.casefold() == self._go_on and elapsed_s >= self._minimum_s:
            return ScreenResult()
        return None

    def erase(self) -> None:
        """Nothing is typed here."""

    def offer(self, typed: str) -> None:
        """Nothing was typed here."""

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """End when the maximum is over."""
        if self._maximum_s is not None and elapsed_s >= self._maximum_s:
            return ScreenResult(timed_out=True)
        return None

    def wait_s(self, elapsed_s: float) -> int:
        """Return the whole seconds until the key works, 0 when it does."""
        return max(math.ceil(self._minimum_s - elapsed_s), 0)


def by_touch(texts: Texts) -> bool:
    """Return whether the participant touches keys that are drawn."""
    return texts["window.touch"] == "yes"


def going_on(texts: Texts, text: str) -> Scene:
    """Return the foot of a screen that says how to go on: a line, or a key to be touched."""
    if not by_touch(texts):
        return (scene.hint(naming_key(texts, text)),)
    label = texts["window.go_on"]
    return scene.button(label, go_on_key(texts), x=0, y=-0.4, width=0.5, height=0.1)


class Reading(Waiting):
    """A text, read at the participant's own pace."""

    def __init__(self, step: Instruct, texts: Texts) -> None:
        super().__init__(texts)
        self._step = step
        self._foot = going_on(
            texts, "window.press_space_last" if step.last else "window.press_space"
        )

    def scene(self, elapsed_s: float) -> Scene:  # noqa: ARG002  a text does not change with time
        """Return title, text and hint; a single paragraph stands in the middle."""
        step, text = self._step, self._step.text.strip()
        title = Text(content=step.title, y=0.36, size=scene.TITLE, bold=True)
        if "\n" in text:
            body = Text(content=text, y=0.28 if step.title else 0.36, anchor="top", align="left",
                        width=1.15, height=0.6)  # fmt: skip
        else:
            body = Text(content=text, y=0.04, size=0.055, width=1.1, height=0.5)
        return (*((title,) if step.title else ()), body, *self._foot)


class Exploring(Waiting):
    """The participant strokes the plate."""

    def __init__(self, step: Explore, texts: Texts) -> None:
        super().__init__(texts, step.minimum_s, step.maximum_s)
        self._step = step
        self._texts = texts

    def scene(self, elapsed_s: float) -> Scene:
        """Return the task, the countdown where there is one, and when one may go on."""
        task = Text(content=self._step.text.strip(), y=0.12, size=0.08, width=1.2, height=0.4)
        wait_s = self.wait_s(elapsed_s)
        if wait_s:
            foot: Scene = (scene.hint(self._texts["window.explore_longer"].format(seconds=wait_s)),)
        else:
            foot = going_on(self._texts, "window.ready_space")
        return (task, *remaining(self._maximum_s, elapsed_s, self._texts, y=-0.17), *foot)


class Resting(Waiting):
    """A break, with the progress."""

    def __init__(self, step: Rest, texts: Texts) -> None:
        super().__init__(texts, step.minimum_s)
        self._step = step
        self._texts = texts

    def scene(self, elapsed_s: float) -> Scene:
        """Return the text, the progress and how long the break still lasts at least."""
        step = self._step
        progress = self._texts["window.progress"].format(done=step.done, total=step.total)
        wait_s = self.wait_s(elapsed_s)
        if wait_s:
            foot: Scene = (scene.hint(self._texts["window.rest_longer"].format(seconds=wait_s)),)
        else:
            foot = going_on(self._texts, "window.press_space")
        return (
            Text(content=step.text.strip(), y=0.14, size=0.055, width=1.1, height=0.4),
            *scene.bar(step.done / step.total if step.total else 0.0, y=-0.12),
            Text(content=progress, y=-0.18, size=scene.HINT, colour="quiet"),
            *foot,
        )


class Telling(Waiting):
    """A text that goes by itself; no key hurries it."""

    def __init__(self, step: Feedback, texts: Texts) -> None:
        super().__init__(texts)
        self._step = step

    def scene(self, elapsed_s: float) -> Scene:  # noqa: ARG002  it stays as it is
        """Return the text."""
        return scene.message(self._step.text.strip())

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:  # noqa: ARG002
        """Take no key."""
        return None

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """End when the time is over: that is no answer missed."""
        return ScreenResult() if elapsed_s >= self._step.duration_s else None


class Listening(Waiting):
    """The participant says a number, which the operator types; or the operator decides."""

    def __init__(self, step: Ask, texts: Texts) -> None:
        super().__init__(texts, maximum_s=step.time_limit_s)
        self._texts = texts
        said = isinstance(step.question, NumberQuestion | WholeNumberQuestion)
        self._prompt = step.question.prompt.strip() if said else ""

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question and that it is answered aloud; a decision is not shown."""
        if not self._prompt:
            return scene.message(self._texts["session.hold"])
        return (
            Text(content=self._prompt, y=0.28, size=0.06, width=1.2, height=0.17),
            Text(content=self._texts["window.say_number"], y=0.02, size=0.06, colour="accent"),
            *remaining(self._maximum_s, elapsed_s, self._texts, y=0.43),
        )

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:  # noqa: ARG002
        """Take no key."""
        return None


class Adjusting(Waiting):
    """The participant turns the plate, by arrow keys or the wheel, or feels the first again."""

    def __init__(self, step: Adjust, texts: Texts) -> None:
        super().__init__(texts, maximum_s=step.time_limit_s)
        self._step = step
        self._texts = texts

    def scene(self, elapsed_s: float) -> Scene:
        """Return what to turn for, the keys, and the countdown where there is one."""
        task = Text(content=self._step.text.strip(), y=0.24, size=0.06, width=1.2, height=0.26)
        texts = self._texts
        labels: tuple[str, ...] = (scene.UP, scene.DOWN)
        meanings: tuple[str, ...] = (texts["window.turn_up"], texts["window.turn_down"])
        if self._step.again:
            labels += (texts["window.again_key"],)
            meanings += (texts["window.feel_again"],)
        left = remaining(self._maximum_s, elapsed_s, self._texts, y=-0.26)
        keys = scene.key_row(labels, meanings, y=0.0, touch=by_touch(self._texts))
        return (task, *keys, *left, *going_on(self._texts, "window.turned"))

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """End on the key that goes on, or on the one that asks to feel again."""
        again = self._texts["window.again_key"].casefold()
        if self._step.again and character.casefold() == again:
            return ScreenResult(value=FEEL_AGAIN)
        return super().press(character, elapsed_s)


class Asking(Unmoved):
    """A question and the place for its answer; the time limit is shown where there is one."""

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

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question, what has been typed, and what was wrong with the last entry."""
        prompt = Text(content=self._prompt, y=0.28, size=0.06, width=1.2, height=0.17)
        left = remaining(self._limit_s, elapsed_s, self._texts, y=0.43)
        return (prompt, *self._body(), *self._foot(), *left)

    def _foot(self) -> Scene:
        """Return what to do, and what was wrong with the last entry."""
        hint = () if self._touch else (scene.hint(self._hint),)
        if not self._notice:
            return hint
        # Keys that are touched reach down to where there is no hint.
        said = scene.notice(self._notice)
        return (replace(said, y=scene.HINT_Y),) if self._touch else (said, *hint)

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """Take a character; end when the entry is an answer given in time."""
        if self.expire(elapsed_s):
            return None
        verdict = self._entry.press(character)
        self._notice = ""
        if isinstance(verdict, entry.Accepted):
            return ScreenResult(value=verdict.value)
        if isinstance(verdict, entry.Refused):
            self._notice = self._texts[verdict.reason].format(**verdict.blanks)
            if verdict.entry:
                self.rejected.append(verdict.entry)
        return None

    def erase(self) -> None:
        """Take back the last character."""
        self._notice = ""
        self._entry.erase()

    def move(self, notches: int) -> None:
        """Move up or down the list."""
        self._notice = ""
        self._entry.turn(notches)

    @property
    def typed(self) -> str:
        """What stands in the place for the answer."""
        return self._entry.content

    def offer(self, typed: str) -> None:
        """Put back what was typed, character by character as a hand would."""
        for character in typed:
            self._entry.press(character)

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """End when the time limit is over."""
        if self._limit_s is not None and elapsed_s >= self._limit_s:
            return ScreenResult(timed_out=True)
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
    """The question whether Escape was meant."""

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
    """Return the size of the digits so that the longest entry fits its field."""
    roomy = 11
    return scene.DIGITS * min(1.0, roomy / max(len(content), 1))


SCREENS: dict[type, Callable[..., Screen]] = {
    Instruct: Reading,
    Explore: Exploring,
    Ask: Asking,
    Rest: Resting,
    Feedback: Telling,
    Adjust: Adjusting,
}


def screen_for(step: ParticipantStep | Adjust, texts: Texts) -> Screen:
    """Return a fresh screen for a step."""
    if isinstance(step, Ask) and step.by == "operator":
        return Listening(step, texts)
    if isinstance(step, Ask) and isinstance(step.question, VisualAnalogueQuestion):
        return Marking(step, step.question, texts)
    return SCREENS[type(step)](step, texts)
