"""Question screen with an answer field, which explains why an entry was rejected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.replies import BACK, Reply
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import ERASE, Entry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.screens.screen_texts import asked, by_touch, remaining

BACK_Y = -0.46  # vertical position below the hint and the touch keys


class Asking(Screen):
    """Screen for a question with an answer field, and a countdown if time is limited.

    Parameters
    ----------
    prompt : str
        The question.
    entry : Entry
        The answer field.
    body : callable
        Returns the drawing of the answer field or keys.
    texts : Mapping
        The texts in the participant's language.
    time_limit_s : float or None
    back : bool
        Whether the participant can return to the previous question.
    """

    def __init__(
        self,
        prompt: str,
        entry: Entry,
        body: Callable[[], Scene],
        texts: Texts,
        *,
        time_limit_s: float | None = None,
        back: bool = False,
    ) -> None:
        super().__init__(texts, time_limit_s)
        self.single_key = entry.single_key
        self._prompt = asked(prompt)
        self._entry = entry
        self._body = body
        self._hint = texts[entry.hint]
        self._touch = by_touch(texts)
        self._notice = ""
        self._back = back

    def scene(self, elapsed_s: float) -> Scene:
        """Return the question, the entry and, after a rejected entry, the reason."""
        left = remaining(self.limit_s, elapsed_s, self.texts, y=0.43)
        return (self._prompt, *self._body(), *self._foot(), *self._way_back(), *left)

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
            words = self.texts["window.back_touch"]
            return scene.button(words, ERASE, x=0.0, y=BACK_Y, width=0.5, height=0.06)
        return (replace(scene.hint(self.texts["window.back"]), y=BACK_Y),)

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Process a character. Return the outcome if the character completes the answer in time."""
        if self.expire(elapsed_s):
            return None
        verdict = self._entry.press(character)
        self._notice = ""
        if isinstance(verdict, Reply):
            return verdict
        if verdict:
            self._notice = self.texts[verdict.reason].format(**verdict.blanks)
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
