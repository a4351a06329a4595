"""The screens that wait for the key that goes on, or for time to pass."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slipscale.experiments.participants.psychopy_window import scene
from slipscale.experiments.participants.psychopy_window.scene import Scene, Text
from slipscale.experiments.participants.psychopy_window.screen_texts import (
    ScreenResult,
    go_on_key,
    naming_key,
    remaining,
)
from slipscale.experiments.protocols.steps import FEEL_AGAIN, NumberQuestion, WholeNumberQuestion

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.experiments.protocols.steps import Adjust, Ask, Explore, Feedback, Instruct, Rest

    Texts = Mapping[str, str]


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
