"""Screens: the mapping from steps to screens, without window or clock.

A screen receives keys and the time since it was shown. It returns what to show and when it is
over. Time is always an argument, so screens can be tested without waiting.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from slipscale.experiments.participants.psychopy_window.asking import Asking
from slipscale.experiments.participants.psychopy_window.pointing import Pointing
from slipscale.experiments.participants.psychopy_window.rating_line import Marking
from slipscale.experiments.participants.psychopy_window.waiting import (
    Adjusting,
    Exploring,
    Listening,
    Reading,
    Resting,
    Telling,
)
from slipscale.experiments.steps.questions import PointingQuestion, VisualAnalogueQuestion
from slipscale.experiments.steps.steps import Adjust, Ask, Explore, Feedback, Instruct, Rest

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from slipscale.experiments.participants.psychopy_window.scene import Scene
    from slipscale.experiments.participants.psychopy_window.screen_texts import ScreenResult
    from slipscale.experiments.steps.steps import ParticipantStep

    Texts = Mapping[str, str]


class Screen(Protocol):
    """One screen.

    If ``single_key`` is True, a key still held from the previous screen could end it by mistake.
    If ``pointed`` is True, the screen needs the mouse.
    """

    single_key: bool
    pointed: bool
    rejected: list[str]

    def scene(self, elapsed_s: float) -> Scene:
        """Return what to show ``elapsed_s`` after the screen appeared."""

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """Process a character; return the outcome if it ended the screen."""

    def erase(self) -> ScreenResult | None:
        """Delete the last character; return the outcome if that ended the screen."""

    def move(self, notches: int) -> None:
        """Move the mark or the selection right or up by notches of the arrow keys or the wheel."""

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> ScreenResult | None:
        """Process a click or touch at a point; return the outcome if it ended the screen."""

    @property
    def typed(self) -> str:
        """The entry typed but not submitted."""

    def offer(self, typed: str) -> None:
        """Restore an entry from before an interruption."""

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """Return the outcome if the screen is over because its time has run out."""


SCREENS: dict[type, Callable[..., Screen]] = {
    Instruct: Reading,
    Explore: Exploring,
    Ask: Asking,
    Rest: Resting,
    Feedback: Telling,
    Adjust: Adjusting,
}


def screen_for(step: ParticipantStep | Adjust, texts: Texts) -> Screen:
    """Return a new screen for a step."""
    if isinstance(step, Ask) and step.by == "operator":
        return Listening(step, texts)
    if isinstance(step, Ask) and isinstance(step.question, VisualAnalogueQuestion):
        return Marking(step, step.question, texts)
    if isinstance(step, Ask) and isinstance(step.question, PointingQuestion):
        return Pointing(step, step.question, texts)
    return SCREENS[type(step)](step, texts)
