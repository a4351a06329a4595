"""Question answered with a free text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens.entry import Entry, TypedEntry
from slipscale.experiments.steps.screens.scene import Box, Scene, Text
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value

CARET = "|"


@dataclass(frozen=True, slots=True, kw_only=True)
class TextQuestion(Question):
    """A question with a free-text answer. The answer is stored verbatim."""

    EXPECTED: ClassVar = "a text"
    max_length: int = 200

    def fits(self, value: object) -> bool:
        """Return whether a value is a text."""
        return isinstance(value, str)

    def rehearsed(self, _place: float, /) -> Value:
        """Return a short text."""
        return "-"

    def entry(self, _texts: Texts, /) -> Entry:
        """Return an answer field for a line of text."""
        return TypedEntry(lambda line: Reply(value=line), "window.enter_text", self.max_length)

    def body(self, entry: Entry, _texts: Texts, /) -> Scene:
        """Return the answer field."""
        return (
            Box(x=0, y=-0.01, width=1.24, height=0.42, colour="field"),
            Text(content=entry.content + CARET, y=0.18, size=0.05, width=1.18, height=0.38,
                 anchor="top", align="left"),
        )  # fmt: skip

    def simulated(self, person: SimulatedPerson, _name: str, /) -> Value:
        """Return the person's verbal report of what disappeared when the level decreased."""
        return person.verbal_report()
