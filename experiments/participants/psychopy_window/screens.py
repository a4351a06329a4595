"""How each step behaves on the screen: a table from step to screen, no window, no clock.

A screen is told of keys and of the time that passed since it was shown, and says what to show and
when it is over. The time is an argument everywhere, so a screen can be tested without waiting.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from slipscale.experiments.participants.psychopy_window.asking import Asking
from slipscale.experiments.participants.psychopy_window.rating_line import Marking
from slipscale.experiments.participants.psychopy_window.waiting import (
    Adjusting,
    Exploring,
    Listening,
    Reading,
    Resting,
    Telling,
)
from slipscale.experiments.protocols.steps import (
    Adjust,
    Ask,
    Explore,
    Feedback,
    Instruct,
    Rest,
    VisualAnalogueQuestion,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from slipscale.experiments.participants.psychopy_window.scene import Scene
    from slipscale.experiments.participants.psychopy_window.screen_texts import ScreenResult
    from slipscale.experiments.protocols.steps import ParticipantStep

    Texts = Mapping[str, str]


class Screen(Protocol):
    """One screen.

    ``single_key`` says that a key held from before could end it by mistake, ``pointed`` that the
    mouse is needed.
    """

    single_key: bool
    pointed: bool
    rejected: list[str]

    def scene(self, elapsed_s: float) -> Scene:
        """Return what to show ``elapsed_s`` after the screen came up."""

    def press(self, character: str, elapsed_s: float) -> ScreenResult | None:
        """Take a character; return the outcome if it ended the screen."""

    def erase(self) -> None:
        """Take back the last character."""

    def move(self, notches: int) -> None:
        """Move what is moved by keys with arrows or the wheel, to the right and up."""

    def point(self, x: float, y: float, elapsed_s: float, *, dragged: bool) -> ScreenResult | None:
        """Take a click or touch at a place of the scene; return the outcome if it ended that."""

    @property
    def typed(self) -> str:
        """What has been typed and not handed in."""

    def offer(self, typed: str) -> None:
        """Show what was typed already, before the screen was interrupted."""

    def expire(self, elapsed_s: float) -> ScreenResult | None:
        """Return the outcome if the time alone ended the screen."""


SCREENS: dict[type, Callable[..., Screen]] = {
    Instruct: Reading,
    Explore: Exploring,
    Ask: Asking,
    Rest: Resting,
    Feedback: Telling,
    Adjust: Adjusting,
}


def screen_for(step: ParticipantStep | Adjust, texts: Texts) -> Screen:
    """Return a fresh screen for a step."""
    if isinstance(step, Ask) and step.by == "operator":
        return Listening(step, texts)
    if isinstance(step, Ask) and isinstance(step.question, VisualAnalogueQuestion):
        return Marking(step, step.question, texts)
    return SCREENS[type(step)](step, texts)
