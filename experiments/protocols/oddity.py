"""Oddity: three surfaces, one of which differs; the participant says which.

No attribute is named, so a difference of any kind counts (the triangle test). The surface to be
found has more or less of the level than the two others; a rule selects by how much.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from slipscale.experiments.protocols.building_blocks.forced_choice import ForcedChoice
from slipscale.experiments.protocols.difference_threshold import PROTOCOL as DIFFERENCE_THRESHOLD
from slipscale.experiments.protocols.difference_threshold import SIGNS, DifferenceThreshold

if TYPE_CHECKING:
    from slipscale.experiments.protocols.base import Context
    from slipscale.experiments.protocols.steps import Steps


class Oddity(DifferenceThreshold):
    """What a study may set for oddity: as for a difference threshold, with three intervals."""

    intervals: Literal[3] = Field(
        default=3,
        description="How many surfaces a trial has, one of them to be found.",
        json_schema_extra={"unit": "intervals"},
    )


def steps(options: Oddity, context: Context) -> Steps:
    """Yield the steps of a run."""
    run = ForcedChoice(
        options,
        context,
        texts="oddity",
        standard_level=options.standard_level,
        sign=SIGNS[options.comparison],
        seeks="odd",
    )
    yield from run.steps()


PROTOCOL = replace(
    DIFFERENCE_THRESHOLD,
    task="oddity",
    title="Difference threshold by oddity",
    description=(
        "Three surfaces are stroked, one of which has more (or less) {q.name} than the two others; "
        "the participant says which one was different. A rule chooses the differences."
    ),
    options=Oddity,
    steps=steps,
    instructions="oddity.instructions",
)
