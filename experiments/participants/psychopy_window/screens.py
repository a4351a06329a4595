"""Map each step to its screen (see `slipscale.experiments.steps.screens.screen`)."""

from __future__ import annotations

from collections.abc import Callable

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.participants.psychopy_window.waiting import (
    Adjusting,
    Exploring,
    Listening,
    Reading,
    Resting,
    Telling,
)
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    Explore,
    Feedback,
    Instruct,
    ParticipantStep,
    Rest,
)


def _asking(step: Ask, texts: Texts) -> Screen:
    if step.by == "operator":
        return Listening(step, texts)
    return step.question.screen(texts, step.time_limit_s, step.back)


SCREENS: dict[type, Callable[..., Screen]] = {
    Instruct: Reading,
    Explore: Exploring,
    Ask: _asking,
    Rest: Resting,
    Feedback: Telling,
    Adjust: Adjusting,
}


def screen_for(step: ParticipantStep | Adjust, texts: Texts) -> Screen:
    """Create the screen for a step."""
    return SCREENS[type(step)](step, texts)
