"""Question answered with a whole number within bounds."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.questions.base import Question, is_number
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens import touch
from slipscale.experiments.steps.screens.entry import Entry, Refused, TypedEntry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeNumberQuestion(Question):
    """Question answered with a whole number from ``minimum`` to ``maximum``, such as an age."""

    EXPECTED: ClassVar = "a whole number within the question's bounds"
    SPOKEN: ClassVar = True
    minimum: int
    maximum: int

    def fits(self, value: object) -> bool:
        """Return whether a value is a whole number within the bounds."""
        return is_number(value) and value in range(self.minimum, self.maximum + 1)

    def rehearsed(self, place: float, /) -> Value:
        """Return the whole number at a position between the bounds."""
        return float(self.minimum + round(place * (self.maximum - self.minimum)))

    def simulated(self, person: SimulatedPerson, name: str, /) -> Value:
        """Return a random number within the bounds."""
        span = self.maximum - self.minimum + 1
        return float(self.minimum + int(person.stream(name).uniform() * span))

    def entry(self, _texts: Texts, /) -> Entry:
        """Return an answer field for a whole number."""
        return TypedEntry(partial(judge_whole_number, minimum=self.minimum, maximum=self.maximum))

    def body(self, entry: Entry, texts: Texts, /) -> Scene:
        """Return the answer field."""
        return touch.number(entry.content, texts)


def judge_whole_number(entry: str, *, minimum: int, maximum: int) -> Reply | Refused:
    """Parse a whole number, and check that it is between two inclusive bounds.

    >>> judge_whole_number(" 34 ", minimum=18, maximum=99).value
    34.0
    >>> judge_whole_number("34,5", minimum=18, maximum=99).reason
    'window.out_of_bounds'
    """
    text = entry.strip()
    # Only ASCII digits are allowed; a number with more digits than the maximum is too large.
    whole = bool(re.fullmatch("[0-9]+", text)) and len(text.lstrip("0")) <= len(str(maximum))
    if whole and minimum <= int(text) <= maximum:
        return Reply(value=float(text))
    blanks = {"entry": text, "minimum": str(minimum), "maximum": str(maximum)}
    return Refused(entry, "window.out_of_bounds", blanks)
