"""Map each step to its screen, independently of any window or clock.

A screen receives key presses and the time since the screen appeared. The screen returns the
contents to draw and, when the screen ends, a `Reply` without times. The time is always passed as an
argument, so tests of screens do not have to wait.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    Explore,
    Feedback,
    Instruct,
    ParticipantStep,
    Rest,
)

if TYPE_CHECKING:
    from slipscale.experiments.participants.psychopy_window.scene import Scene
    from slipscale.experiments.steps.replies import Reply

    Texts = Mapping[str, str]


class Screen(Protocol):
    """Common interface for screens.

    If ``single_key`` is True, a single key press ends the screen, so the participant must first
    release keys held since the previous screen. If ``pointed`` is True, the screen is operated with
    the mouse, and the pointer is visible.
    """

    single_key: bool
    pointed: bool
    rejected: list[str]

    def scene(self, elapsed_s: float) -> Scene:
        """Return the contents of the screen ``elapsed_s`` after it appeared."""

    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Process a character; return the outcome if the character ended the screen."""

    def erase(self) -> Reply | None:
        """Delete the last character; return the outcome if this closes the screen."""

    def move(self, notches: int) -> None:
        """Move the mark to the right, or the selection up, by a number of notches."""

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> Reply | None:
        """Process a click or touch. Return the outcome if the click or touch ended the screen."""

    @property
    def typed(self) -> str:
        """The entry that has been typed but not submitted."""

    def offer(self, typed: str) -> None:
        """Restore the entry that the participant typed before an interruption."""

    def expire(self, elapsed_s: float) -> Reply | None:
        """Return the screen's result if its time limit has passed."""


SCREENS: dict[type, Callable[..., Screen]] = {
    Instruct: Reading,
    Explore: Exploring,
    Ask: Asking,
    Rest: Resting,
    Feedback: Telling,
    Adjust: Adjusting,
}


def screen_for(step: ParticipantStep | Adjust, texts: Texts) -> Screen:
    """Create the screen for a step."""
    if isinstance(step, Ask) and step.by == "operator":
        return Listening(step, texts)
    if isinstance(step, Ask) and isinstance(step.question, VisualAnalogueQuestion):
        return Marking(step, step.question, texts)
    if isinstance(step, Ask) and isinstance(step.question, PointingQuestion):
        return Pointing(step, step.question, texts)
    return SCREENS[type(step)](step, texts)
