"""Oddity: the participant identifies which of three surfaces differs from the other two.

This is the triangle test: no attribute is named, so any kind of difference counts. The target
surface has a higher or lower level than the other two surfaces, and an adaptive rule selects the
difference.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from slipscale.experiments.protocol_parts.base import Context
from slipscale.experiments.protocol_parts.building_blocks.forced_choice import ForcedChoice
from slipscale.experiments.protocols.difference_threshold import PROTOCOL as DIFFERENCE_THRESHOLD
from slipscale.experiments.protocols.difference_threshold import SIGNS, DifferenceThreshold
from slipscale.experiments.steps.steps import Steps
from slipscale.faults.frozen_table import setting


class Oddity(DifferenceThreshold):
    """Options for oddity, the same as for a difference threshold but with three intervals."""

    intervals: Literal[3] = setting(
        3, "Number of surfaces in a trial, one of which is the target.", unit="intervals"
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
        "The participant strokes three surfaces, one of which has more (or less) {q.name} than "
        "the other two, and says which surface was different. An adaptive rule chooses the "
        "differences."
    ),
    options=Oddity,
    steps=steps,
    instructions="oddity.instructions",
)
