"""Whether every screen of a study can be read, in every language that the study has."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from slipscale.experiments.languages.texts import languages
from slipscale.experiments.participants.psychopy_window.layout import faults
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.protocols.steps import (
    Adjust,
    Ask,
    EndBlock,
    Explore,
    Feedback,
    Instruct,
    Rest,
)
from slipscale.experiments.running.rehearsal import WAYS, dry_run
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from slipscale.experiments.participants.psychopy_window.scene import Scene
    from slipscale.experiments.protocols.steps import Step
    from slipscale.experiments.study.run_plan import RunPlan

SHOWN = (Instruct, Explore, Ask, Rest, Feedback, Adjust)
MOST_TOLD = 8


def check_screens(plan: RunPlan) -> None:
    """Raise `UserError` if a screen of a plan cannot be read in one of its languages.

    Parameters
    ----------
    plan : RunPlan
        Of any participant. Questions without words in a language are passed over, except in the
        plan's own.
    """
    told: dict[str, None] = {}
    for language in dict.fromkeys((plan.language, *languages(), *plan.study.texts)):
        spoken = replace(plan, language=language)
        if language != plan.language:
            with suppress(UserError):
                spoken.context()
                spoken.person_questions()
                told |= dict.fromkeys(f"{language}: {each}" for each in _faults(spoken))
            continue
        told |= dict.fromkeys(f"{language}: {each}" for each in _faults(spoken))
    if told:
        lines = "".join(f"\n  {sentence}" for sentence in list(told)[:MOST_TOLD])
        more = f"\n  and {len(told) - MOST_TOLD} more" if len(told) > MOST_TOLD else ""
        raise UserError(
            f"{plan.study_name}: screens that cannot be read; shorten the texts:{lines}{more}"
        )


def _faults(plan: RunPlan) -> Iterator[str]:
    seen: set[Scene] = set()
    for way in WAYS.values():
        for step in dry_run(plan, way):
            for scene in _scenes(step, plan):
                if scene not in seen:
                    seen.add(scene)
                    yield from faults(scene)


def _scenes(step: Step, plan: RunPlan) -> Iterator[Scene]:
    """Yield what a step shows at first, and once its minimum is over."""
    shown = step.screen if isinstance(step, EndBlock) else step
    if isinstance(shown, SHOWN):
        screen = screen_for(shown, plan.texts())
        yield screen.scene(0.0)
        yield screen.scene(1e6)
