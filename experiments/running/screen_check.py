"""Check that every screen of a study is readable in every language of the study."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

from slipscale.experiments.languages.texts import languages
from slipscale.experiments.participants.psychopy_window.layout import faults
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.running.rehearsal import WAYS, dry_run
from slipscale.experiments.steps.screens.scene import Scene, progress_line
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    EndBlock,
    Explore,
    Feedback,
    Instruct,
    Rest,
    Step,
)
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError

SHOWN = (Instruct, Explore, Ask, Rest, Feedback, Adjust)
MOST_TOLD = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """A screen of a run, and the reasons why this screen is not readable.

    Parameters
    ----------
    task : str
        Label of the task to which the screen belongs; empty between trials.
    step : str
        Type of the session step that shows the screen.
    faults : tuple of str
        Reasons why the screen is not readable; empty if there are none.
    """

    task: str
    step: str
    scene: Scene
    faults: tuple[str, ...]


def check_screens(plan: RunPlan) -> None:
    """Raise `UserError` unless every screen of a plan is readable in all of its languages.

    Parameters
    ----------
    plan : RunPlan
        Plan of any participant's run. Questions without a translation are skipped, except in the
        plan's own language.
    """
    faults = [
        f"{spoken.language}: {fault}"
        for spoken in in_each_language(plan)
        for fault in dict.fromkeys(each for seen in every_screen(spoken) for each in seen.faults)
    ]
    if faults:
        lines = "".join(f"\n  {sentence}" for sentence in faults[:MOST_TOLD])
        more = f"\n  and {len(faults) - MOST_TOLD} more" if len(faults) > MOST_TOLD else ""
        raise UserError(
            "{study_name}: some screens cannot be shown properly; shorten the texts:{lines}{more}",
            study_name=plan.study_name,
            lines=lines,
            more=more,
        )


def in_each_language(plan: RunPlan) -> Iterator[RunPlan]:
    """Yield a plan in its own language, then in each other language of the study."""
    yield plan
    for language in dict.fromkeys((*languages(), *plan.study.texts)):
        if language != plan.language:
            spoken = replace(plan, language=language)
            with suppress(UserError):
                spoken.context()
                spoken.person_questions()
                yield spoken


def every_screen(plan: RunPlan) -> Iterator[Seen]:
    """Yield the distinct screens of a run in order of first appearance."""
    for task, step, scene in distinct_scenes(plan):
        yield Seen(
            task=task, step=step, scene=scene, faults=tuple(faults(scene, plan.study.screens))
        )


def distinct_scenes(plan: RunPlan) -> Iterator[tuple[str, str, Scene]]:
    """Yield the task, the type of step and the scene of every distinct screen of a run."""
    seen: set[Scene] = set()
    for way in WAYS.values():
        for step in dry_run(plan, way):
            for scene in _scenes(step, plan):
                if scene not in seen:
                    seen.add(scene)
                    yield step.trial.task if step.trial else "", type(step).__name__, scene


def _scenes(step: Step, plan: RunPlan) -> Iterator[Scene]:
    """Yield a step's screen twice: at its start and after its minimum duration."""
    shown = step.screen if isinstance(step, EndBlock) else step
    if isinstance(shown, SHOWN):
        screen = screen_for(shown, plan.texts())
        line = progress_line(0.5) if plan.study.progress_line and step.trial else ()
        yield (*screen.scene(0.0), *line)
        yield (*screen.scene(1e6), *line)
