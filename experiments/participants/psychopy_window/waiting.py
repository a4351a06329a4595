"""Screens that wait for a key press or until a time has passed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.replies import FEEL_AGAIN, Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.asking import Asking
from slipscale.experiments.steps.screens.entry import KeyEntry
from slipscale.experiments.steps.screens.scene import Scene, Text
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.screens.screen_texts import (
    asked,
    by_touch,
    go_on_key,
    going_on,
    remaining,
    yes_no_keys,
)

if TYPE_CHECKING:
    from slipscale.experiments.steps.steps import Adjust, Ask, Explore, Feedback, Instruct, Rest

PACER_WIDTH, PACER_Y = 0.8, -0.07


class Waiting(Screen):
    """Base class for screens that wait for the continue key, usually the space bar."""

    def __init__(
        self, texts: Texts, minimum_s: float = 0.0, maximum_s: float | None = None
    ) -> None:
        super().__init__(texts, maximum_s)
        self._go_on = go_on_key(texts)
        self._minimum_s = minimum_s

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """End the screen if the continue key is pressed after the minimum time has passed."""
        if character.casefold() == self._go_on and elapsed_s >= self._minimum_s:
            return Reply()
        return None

    def wait_s(self, elapsed_s: float) -> int:
        """Return the time in s, rounded up, until the continue key becomes active."""
        return max(math.ceil(self._minimum_s - elapsed_s), 0)


class Reading(Waiting):
    """Screen with a text that the participant reads at their own pace."""

    def __init__(self, step: Instruct, texts: Texts) -> None:
        super().__init__(texts)
        self._step = step
        self._foot = going_on(
            texts, "window.press_space_last" if step.last else "window.press_space"
        )

    def scene(self, elapsed_s: float) -> Scene:  # noqa: ARG002  the text is constant
        """Return the title, the text and a hint on how to continue.

        A text of a single paragraph is centred vertically.
        """
        step, text = self._step, self._step.text.strip()
        title = Text(content=step.title, y=0.36, size=scene.TITLE, bold=True)
        if "\n" in text:
            body = Text(content=text, y=0.28 if step.title else 0.36, anchor="top", align="left",
                        width=1.15, height=0.6)  # fmt: skip
        else:
            body = Text(content=text, y=0.04, size=0.055, width=1.1, height=0.5)
        return (*((title,) if step.title else ()), body, *self._foot)


class Exploring(Waiting):
    """Screen shown while the participant explores the plate."""

    def __init__(self, step: Explore, texts: Texts) -> None:
        super().__init__(texts, step.minimum_s, step.maximum_s)
        self._step = step

    def scene(self, elapsed_s: float) -> Scene:
        """Return the task, a hint on how to continue, and the countdown if time is limited."""
        task = Text(content=self._step.text.strip(), y=0.12, size=0.08, width=1.2, height=0.4)
        wait_s = self.wait_s(elapsed_s)
        if wait_s:
            foot: Scene = (scene.hint(self.texts["window.explore_longer"].format(seconds=wait_s)),)
        else:
            foot = going_on(self.texts, "window.ready_space")
        left = remaining(self.limit_s, elapsed_s, self.texts, y=-0.17)
        return (task, *self._pacer(elapsed_s), *left, *foot)

    def _pacer(self, elapsed_s: float) -> Scene:
        """Return a mark that moves at the stroke speed, or nothing if no mark is requested."""
        guide = self._step.guide
        share = guide.place_share(elapsed_s) if guide else None
        if share is None:
            return ()
        x = PACER_WIDTH * (share - 0.5)
        return (
            scene.Box(x=0, y=PACER_Y, width=PACER_WIDTH, height=0.006, colour="quiet"),
            scene.Disc(x=x, y=PACER_Y, diameter=0.04, colour="accent"),
        )


class Resting(Waiting):
    """Break screen, which shows the participant's progress."""

    def __init__(self, step: Rest, texts: Texts) -> None:
        super().__init__(texts, step.minimum_s)
        self._step = step

    def scene(self, elapsed_s: float) -> Scene:
        """Return the rest text, the progress, and a hint on how to continue or how long to wait."""
        step = self._step
        progress = self.texts["window.progress"].format(done=step.done, total=step.total)
        wait_s = self.wait_s(elapsed_s)
        if wait_s:
            foot: Scene = (scene.hint(self.texts["window.rest_longer"].format(seconds=wait_s)),)
        else:
            foot = going_on(self.texts, "window.press_space")
        return (
            Text(content=step.text.strip(), y=0.14, size=0.055, width=1.1, height=0.4),
            *scene.bar(step.done / step.total if step.total else 0.0, y=-0.12),
            Text(content=progress, y=-0.18, size=scene.HINT, colour="quiet"),
            *foot,
        )


class Telling(Waiting):
    """Screen with a text that disappears after a fixed time. Keys are ignored."""

    def __init__(self, step: Feedback, texts: Texts) -> None:
        super().__init__(texts)
        self._step = step

    def scene(self, elapsed_s: float) -> Scene:  # noqa: ARG002  it is constant
        """Return the text."""
        return scene.message(self._step.text.strip())

    def press(self, character: str, elapsed_s: float) -> Reply | None:  # noqa: ARG002
        """Ignore the key."""
        return None

    def expire(self, elapsed_s: float) -> Reply | None:
        """End the screen after its duration, without reporting a time-out."""
        return Reply() if elapsed_s >= self._step.duration_s else None


class Listening(Waiting):
    """The screen shown while the operator enters a spoken number or makes a decision."""

    def __init__(self, step: Ask, texts: Texts) -> None:
        super().__init__(texts, maximum_s=step.time_limit_s)
        self._prompt = step.question.prompt.strip() if step.question.SPOKEN else ""

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question and a request to answer aloud. Operator decisions are not shown."""
        if not self._prompt:
            return scene.message(self.texts["session.hold"])
        return (
            asked(self._prompt),
            Text(content=self.texts["window.say_number"], y=0.02, size=0.06, colour="accent"),
            *remaining(self.limit_s, elapsed_s, self.texts, y=0.43),
        )

    def press(self, character: str, elapsed_s: float) -> Reply | None:  # noqa: ARG002
        """Ignore the key."""
        return None


class Adjusting(Waiting):
    """The screen on which the participant adjusts the plate or requests the reference."""

    def __init__(self, step: Adjust, texts: Texts) -> None:
        super().__init__(texts, maximum_s=step.time_limit_s)
        self._step = step

    def scene(self, elapsed_s: float) -> Scene:
        """Return the task, the keys and, if time is limited, the countdown."""
        task = Text(content=self._step.text.strip(), y=0.24, size=0.06, width=1.2, height=0.26)
        texts = self.texts
        labels: tuple[str, ...] = (scene.UP, scene.DOWN)
        meanings: tuple[str, ...] = (texts["window.turn_up"], texts["window.turn_down"])
        if self._step.again:
            labels += (texts["window.again_key"],)
            meanings += (texts["window.feel_again"],)
        left = remaining(self.limit_s, elapsed_s, self.texts, y=-0.26)
        keys = scene.key_row(labels, meanings, y=0.0, touch=by_touch(self.texts))
        return (task, *keys, *left, *going_on(self.texts, "window.turned"))

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """End the screen on the key to continue, or on the key to feel the reference again."""
        again = self.texts["window.again_key"].casefold()
        if self._step.again and character.casefold() == again:
            return Reply(value=FEEL_AGAIN)
        return super().press(character, elapsed_s)


class Stopping(Asking):
    """Screen that asks whether the participant pressed Escape intentionally."""

    def __init__(self, texts: Texts) -> None:
        drawn = (
            *yes_no_keys(texts, "window.stop_yes", "window.stop_no", y=0.06),
            Text(content=texts["window.stop_note"], y=-0.19, size=scene.HINT, colour="quiet"),
        )
        keys = KeyEntry.yes_no(texts)
        super().__init__(texts["window.stop"], keys, lambda: drawn, texts)
