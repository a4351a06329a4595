"""Question answered by choosing one of several surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.questions.base import Question, Sought, option_at
from slipscale.experiments.steps.screens import scene
from slipscale.experiments.steps.screens.entry import Entry, KeyEntry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.screens.screen_texts import by_touch
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonQuestion(Question):
    """Question answered by choosing one of several surfaces; the reply's value is its number.

    ``options`` contains the labels on the screen, in the order of presentation ("the first", ...).
    ``seeks`` specifies whether the question asks for the most slippery, the least slippery or the
    odd surface.
    """

    EXPECTED: ClassVar = "the number of an interval"
    options: tuple[str, ...]
    seeks: Sought = "most"

    def fits(self, value: object) -> bool:
        """Return whether a value is the number of an interval."""
        return value in self._numbers

    def rehearsed(self, place: float, /) -> Value:
        """Return the number of the interval at a position."""
        return option_at(place, self._numbers)

    @property
    def _numbers(self) -> tuple[float, ...]:
        return tuple(float(number) for number in range(1, len(self.options) + 1))

    def entry(self, _texts: Texts, /) -> Entry:
        """Return an answer field with one number key per interval."""
        return KeyEntry.numbered(self._numbers, self.prompt)

    def body(self, _entry: Entry, texts: Texts, /) -> Scene:
        """Return the keys with the options below."""
        keys = tuple(f"{number:g}" for number in self._numbers)
        return scene.key_row(keys, self.options, y=0.02, touch=by_touch(texts))

    def simulated(self, person: SimulatedPerson, _name: str, /) -> Value:
        """Return the interval that seemed most (or least) slippery, or differed most."""
        felt = person.impressions
        if self.seeks == "odd":
            total = sum(felt)
            return float(1 + person.pick([abs(len(felt) * each - total) for each in felt]))
        sign = 1 if self.seeks == "most" else -1
        return float(1 + person.pick([sign * each for each in felt]))
