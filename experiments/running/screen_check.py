"""Whether every screen of a study can be read, in every language that the study has."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """A screen of a run.

    Parameters
    ----------
    task : str
        Label of the task whose trial shows it; empty between trials.
    step : str
        Type of the step that shows it.
    faults : tuple of str
        Why it cannot be read; none if it can.
    """

    task: str
    step: str
    scene: Scene
    faults: tuple[str, ...]


def check_screens(plan: RunPlan) -> None:
    """Raise `UserError` if a screen of a plan cannot be read in one of its languages.

    Parameters
    ----------
    plan : RunPlan
        Of any participant. Questions without words in a language are passed over, except in the
        plan's own.
    """
    told = [
        f"{spoken.language}: {fault}"
        for spoken in in_each_language(plan)
        for fault in dict.fromkeys(each for seen in every_screen(spoken) for each in seen.faults)
    ]
    if told:
        lines = "".join(f"\n  {sentence}" for sentence in told[:MOST_TOLD])
        more = f"\n  and {len(told) - MOST_TOLD} more" if len(told) > MOST_TOLD else ""
        raise UserError(
            f"{plan.study_name}: screens that cannot be read; shorten the texts:{lines}{more}"
        )


def in_each_language(plan: RunPlan) -> Iterator[RunPlan]:
    """Yield a plan in its own language, then in each other one that the study has words in."""
    yield plan
    for language in dict.fromkeys((*languages(), *plan.study.texts)):
        if language != plan.language:
            spoken = replace(plan, language=language)
            with suppress(UserError):
                spoken.context()
                spoken.person_questions()
                yield spoken


def every_screen(plan: RunPlan) -> Iterator[Seen]:
    """Yield each different screen of a run once, as it comes first."""
    seen: set[Scene] = set()
    for way in WAYS.values():
        for step in dry_run(plan, way):
            for scene in _scenes(step, plan):
                if scene not in seen:
                    seen.add(scene)
                    yield Seen(
                        task=step.trial.task if step.trial else "",
                        step=type(step).__name__,
                        scene=scene,
                        faults=tuple(faults(scene)),
                    )


def _scenes(step: Step, plan: RunPlan) -> Iterator[Scene]:
    """Yield what a step shows at first, and once its minimum is over."""
    shown = step.screen if isinstance(step, EndBlock) else step
    if isinstance(shown, SHOWN):
        screen = screen_for(shown, plan.texts())
        yield screen.scene(0.0)
        yield screen.scene(1e6)
