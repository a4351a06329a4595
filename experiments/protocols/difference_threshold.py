"""Difference threshold by forced choice: the smallest change in amplitude that can be felt.

Each trial presents two or three surfaces. One surface has a larger (or smaller) amplitude than the
standard; the trial's *level* is the difference. The participant chooses the surface that was more
(or less) slippery. An adaptive rule selects the levels.
"""

from __future__ import annotations

from typing import Literal

from slipscale.experiments.protocol_parts.base import Amplitude, Context, Protocol
from slipscale.experiments.protocol_parts.building_blocks.forced_choice import (
    DESIGN,
    RESPONSE,
    SIMULATED,
    STIMULUS,
    ForcedChoice,
    ForcedChoiceOptions,
    expected_trials,
    intervals_of,
    most_trials,
)
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.rounding import rounded
from slipscale.experiments.steps.steps import Steps
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting

SIGNS = {"more": 1, "less": -1}


class DifferenceThreshold(ForcedChoiceOptions):
    """Options for a difference threshold."""

    standard_level: Amplitude = setting(
        1.2, "Amplitude of the standard, to which the other surfaces are compared."
    )
    comparison: Literal["more", "less"] = setting(
        "more",
        "Whether the target surface has a larger or a smaller amplitude than the standard; the "
        "question is worded accordingly.",
    )

    def compared_level(self, level: float) -> float:
        """Return the amplitude of the target surface, µm peak to peak."""
        return rounded(self.standard_level + SIGNS[self.comparison] * level)


def check(options: DifferenceThreshold, context: Context) -> None:
    """Raise `UserError` if the options contradict each other."""
    options.begin(options.guess, context.stream)
    q = context.quantity
    if options.compared_level(options.highest_level) < 0:
        raise UserError(
            "{key} is {highest_level:g}, but must be at most the standard ({standard_level})",
            key=q.named("highest_level"),
            highest_level=options.highest_level,
            standard_level=q.short(options.standard_level),
        )


def possible_levels(options: DifferenceThreshold, _context: Context) -> tuple[float, ...]:
    """Return the amplitudes of the standard and of the nearest and furthest targets."""
    levels = (0.0, options.lowest_level, options.highest_level)
    return tuple(options.compared_level(level) for level in levels)


def finest_level(options: DifferenceThreshold, _context: Context) -> tuple[float, float]:
    """Return the smallest difference from the standard, and the higher of the two amplitudes."""
    nearest = options.compared_level(options.lowest_level)
    return options.lowest_level, max(nearest, options.standard_level)


def _standard(record: TrialRecord) -> float | None:
    """Return the amplitude of the first interval that did not contain the target."""
    target = record.trial.factors["target_interval"]
    others = (each for number, each in sorted(record.intervals.items()) if number != target)
    return next((each.surface.level for each in others), None)


def steps(options: DifferenceThreshold, context: Context) -> Steps:
    """Yield the steps of a run."""
    run = ForcedChoice(
        options,
        context,
        texts=f"difference_threshold.{options.comparison}",
        standard_level=options.standard_level,
        sign=SIGNS[options.comparison],
    )
    yield from run.steps()


PROTOCOL = Protocol(
    task="differencethreshold",
    title="Difference threshold by forced choice",
    description=(
        "The participant strokes two or three surfaces, one of which has more (or less) "
        "{q.name} than the standard, and names the surface that was more (or less) "
        "{q.adjective}. An adaptive rule chooses the differences."
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
        "standard_level": Column(
            value=_standard, description="{q.title} of the standard{q.behind}", units="{q.bids}"
        ),
        **STIMULUS,
    },
    response=RESPONSE,
    intervals=intervals_of,
    amplitudes=("standard_level", "start_level", "lowest_level", "highest_level"),
    possible_levels=possible_levels,
    finest_level=finest_level,
    check=check,
)
