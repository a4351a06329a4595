"""Difference threshold by forced choice: how small a change of amplitude is still felt.

In each trial one of two or three intervals holds a surface that is a *level* above (or below) the
standard; the participant says which one was more (or less) slippery. A rule chooses the levels.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import Field

from slipscale.experiments.protocols.adaptive.track import rounded
from slipscale.experiments.protocols.base import Amplitude, Column, Protocol
from slipscale.experiments.protocols.building_blocks.forced_choice import (
    DESIGN,
    RESPONSE,
    SIMULATED,
    STIMULUS,
    ForcedChoice,
    ForcedChoiceOptions,
    expected_trials,
    most_trials,
)
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.protocols.base import Context, TrialRecord
    from slipscale.experiments.protocols.steps import Steps

SIGNS = {"more": 1, "less": -1}


class DifferenceThreshold(ForcedChoiceOptions):
    """What a study may set for a difference threshold."""

    standard_um_pp: Amplitude = Field(
        default=1.2, description="Amplitude of the standard, with which the others are compared."
    )
    comparison: Literal["more", "less"] = Field(
        default="more",
        description="Whether the surface to be found has more amplitude than the standard, or "
        "less; the question follows.",
    )

    def compared_um_pp(self, level_um_pp: float) -> float:
        """Return the amplitude of the surface to be found, µm peak to peak."""
        return rounded(self.standard_um_pp + SIGNS[self.comparison] * level_um_pp)


def check(options: DifferenceThreshold, context: Context) -> None:
    """Raise `UserError` where the options contradict each other."""
    options.begin(options.guess, context.stream)
    if options.compared_um_pp(options.highest_um_pp) < 0:
        raise UserError(
            f"highest_um_pp is {options.highest_um_pp:g}, more than the standard "
            f"({options.standard_um_pp:g} µm p-p) can lose"
        )


def possible_um_pp(options: DifferenceThreshold, _context: Context) -> tuple[float, ...]:
    """Return the standard, and the nearest and the furthest surface to be found."""
    levels = (0.0, options.lowest_um_pp, options.highest_um_pp)
    return tuple(options.compared_um_pp(level) for level in levels)


def finest_um_pp(options: DifferenceThreshold, _context: Context) -> tuple[float, float]:
    """Return the lowest level, and the larger of the two amplitudes that it is between."""
    nearest = options.compared_um_pp(options.lowest_um_pp)
    return options.lowest_um_pp, max(nearest, options.standard_um_pp)


def _standard(record: TrialRecord) -> float | None:
    """Return the amplitude of the first interval that did not hold what was to be found."""
    target = record.trial.factors["target_interval"]
    others = (each for number, each in sorted(record.intervals.items()) if number != target)
    return next((each.surface.amplitude_um_pp for each in others), None)


def steps(options: DifferenceThreshold, context: Context) -> Steps:
    """Yield the steps of a run."""
    run = ForcedChoice(
        options,
        context,
        texts=f"difference_threshold.{options.comparison}",
        standard_um_pp=options.standard_um_pp,
        sign=SIGNS[options.comparison],
    )
    yield from run.steps()


PROTOCOL = Protocol(
    task="differencethreshold",
    title="Difference threshold by forced choice",
    description=(
        "Two or three surfaces are stroked, one of which has more (or less) amplitude than the "
        "standard; the participant says which one was more (or less) slippery. A rule chooses the "
        "differences."
    ),
    options=DifferenceThreshold,
    trials=expected_trials,
    most_trials=most_trials,
    steps=steps,
    answer="response",
    instructions="difference_threshold.more.instructions",
    simulated=SIMULATED,
    design=DESIGN,
    stimulus={
        "standard_um_pp": Column(
            value=_standard,
            kind="number",
            description="Amplitude of the standard, peak to peak",
            units="um",
        ),
        **STIMULUS,
    },
    response=RESPONSE,
    intervals=lambda options: options.intervals,
    amplitudes=("standard_um_pp", "start_um_pp", "lowest_um_pp", "highest_um_pp"),
    possible_um_pp=possible_um_pp,
    finest_um_pp=finest_um_pp,
    check=check,
)
