"""Question answered with yes or no."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.questions.base import Question, Sought
from slipscale.experiments.steps.screens.entry import Entry, KeyEntry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.screens.screen_texts import yes_no_keys
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoQuestion(Question):
    """A yes/no question; the reply's value is a bool.

    For a comparison of surfaces, ``seeks`` specifies whether "yes" means more or less slippery.
    """

    EXPECTED: ClassVar = "true or false"
    seeks: Sought = "most"

    def fits(self, value: object) -> bool:
        """Return whether a value is a bool."""
        return isinstance(value, bool)

    def rehearsed(self, place: float, /) -> Value:
        """Return "yes" in the first half of the range."""
        return place < 0.5  # noqa: PLR2004 - half of the range

    def entry(self, texts: Texts, /) -> Entry:
        """Return an answer field with the keys for yes and no."""
        return KeyEntry.yes_no(texts)

    def body(self, _entry: Entry, texts: Texts, /) -> Scene:
        """Return the two keys."""
        return yes_no_keys(texts, "window.yes", "window.no", y=0.02)

    def simulated(self, person: SimulatedPerson, _name: str, /) -> Value:
        """Return whether the person perceives a difference between the last two surfaces."""
        return person.notices()
