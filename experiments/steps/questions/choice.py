"""Question answered by choosing one of several options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slipscale.experiments.languages.texts import NUMBER_KEYS, Texts
from slipscale.experiments.steps.questions.base import Question, option_at
from slipscale.experiments.steps.screens import scene, touch
from slipscale.experiments.steps.screens.entry import Entry, KeyEntry, ListEntry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.screens.screen_texts import by_touch
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceQuestion(Question):
    """Choice from ``options``, each of which is a pair of a code (for the data) and a label."""

    EXPECTED: ClassVar = "the code of one of the options"
    options: tuple[tuple[str, str], ...]

    def fits(self, value: object) -> bool:
        """Return whether a value is the code of an option."""
        return value in [code for code, _ in self.options]

    def rehearsed(self, place: float, /) -> Value:
        """Return the code of the option at a position."""
        return option_at(place, self.options)[0]

    def simulated(self, person: SimulatedPerson, name: str, /) -> Value:
        """Return the code of a random option, because no option is known to be correct."""
        return person.stream(name).choice(self.options)[0]

    @property
    def listed(self) -> tuple[str, ...]:
        """Labels of the options."""
        return tuple(label for _, label in self.options)

    @property
    def is_long(self) -> bool:
        """Whether there are more options than number keys, so that a list is required."""
        return len(self.options) > NUMBER_KEYS

    def entry(self, _texts: Texts, /) -> Entry:
        """Return an answer field with number keys or, if there are too few keys, a list."""
        codes = tuple(code for code, _ in self.options)
        return ListEntry(codes) if self.is_long else KeyEntry.numbered(codes, self.prompt)

    def body(self, entry: Entry, texts: Texts, /) -> Scene:
        """Return the options next to their keys, or the list."""
        if self.is_long:
            return touch.scrolled(self.listed, entry.place, entry.content, texts)
        return scene.key_list(self.listed, top=0.17, height=0.43, touch=by_touch(texts))
