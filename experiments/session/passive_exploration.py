"""Move the stage during passive explorations.

The stage moves only while the participant explores, and then returns to its start, so every
exploration begins at the same position.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from slipscale.faults import UserError
from slipscale.hardware.contact.stage import Stage, Strokes

if TYPE_CHECKING:
    from slipscale.experiments.participants.base import Watch
    from slipscale.experiments.steps.steps import Explore
    from slipscale.experiments.study.stroke import Stroke
    from slipscale.hardware.contact.source import ContactSource, Kind


def stage_of(stroke: Stroke | None, sources: Mapping[Kind, ContactSource]) -> Stage | None:
    """Return the stage for a study with passive strokes; None if the strokes are not passive.

    Raises
    ------
    UserError
        If there is no stage for passive strokes, if there is a stage but no passive strokes, or if
        the strokes exceed the stage's limits.
    """
    position, passive = sources.get("position"), stroke is not None and stroke.passive
    if passive and not isinstance(position, Stage):
        raise UserError(
            "[stroke] is passive, but no stage measures the position; specify a stage with "
            "--position, for example emulated_stage"
        )
    if isinstance(position, Stage) and not passive:
        raise UserError(
            "--position {position_name}: a stage moves the plate, but the study's [stroke] is "
            "not passive; expected passive = true",
            position_name=position.name,
        )
    if not (isinstance(position, Stage) and stroke and stroke.speed_mm_s):
        return None
    position.check(Strokes(speed_mm_s=stroke.speed_mm_s, length_mm=stroke.stroke_mm))
    return position


@contextmanager
def moved(stage: Stage | None, step: Explore, watch: Watch) -> Iterator[Watch]:
    """Move the stage back and forth during an exploration, and always stop it afterwards.

    Yields the function to call in every frame. Outside trials, this function reads the stage's
    samples without recording them, so that the stage can reverse its direction.
    """
    guide = step.guide
    if stage is None or guide is None or guide.speed_mm_s is None:
        yield watch
        return

    def turning() -> None:
        watch()
        stage.take()

    strokes = Strokes(
        speed_mm_s=guide.speed_mm_s,
        length_mm=guide.stroke_mm,
        direction=guide.direction,
        normal_n=guide.normal_force_n,
    )
    try:
        stage.home(strokes, watch)
        stage.stroke(strokes)
        yield watch if step.trial else turning
    finally:
        stage.stop()
    stage.home(strokes, watch)
