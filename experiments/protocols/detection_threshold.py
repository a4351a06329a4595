"""Detection threshold by forced choice: the smallest vibration that can be felt.

In each trial the plate vibrates in one of two or three intervals and is at rest in the other
intervals. The participant chooses the most slippery interval. An adaptive rule selects the
amplitudes.
"""

from __future__ import annotations

from slipscale.experiments.protocol_parts.base import Context, Protocol
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
from slipscale.experiments.steps.steps import Steps

REST_UM_PP = 0.0


class DetectionThreshold(ForcedChoiceOptions):
    """Options for a detection threshold, whose levels are the amplitudes themselves."""


def check(options: DetectionThreshold, context: Context) -> None:
    """Raise `UserError` if the options contradict each other."""
    options.begin(options.guess, context.stream)


def possible_levels(options: DetectionThreshold, _context: Context) -> tuple[float, ...]:
    """Return the amplitude of the plate at rest, and the lowest and highest amplitudes."""
    return REST_UM_PP, options.lowest_level, options.highest_level


def finest_level(options: DetectionThreshold, _context: Context) -> tuple[float, float]:
    """Return the smallest difference and its amplitude; both equal the lowest amplitude."""
    return options.lowest_level, options.lowest_level


def steps(options: DetectionThreshold, context: Context) -> Steps:
    """Yield the steps of a run."""
    run = ForcedChoice(options, context, texts="detection_threshold", standard_level=REST_UM_PP)
    yield from run.steps()


PROTOCOL = Protocol(
    task="detectionthreshold",
    title="Detection threshold by forced choice",
    description=(
        "The plate vibrates in one of two or three intervals and is at rest in the other "
        "intervals; the participant names the interval in which the plate was {q.more}. An "
        "adaptive rule chooses the {q.levels}."
    ),
    options=DetectionThreshold,
    trials=expected_trials,
    most_trials=most_trials,
    steps=steps,
    answer="response",
    instructions="detection_threshold.instructions",
    simulated=SIMULATED,
    design=DESIGN,
    stimulus=STIMULUS,
    response=RESPONSE,
    intervals=intervals_of,
    amplitudes=("start_level", "lowest_level", "highest_level"),
    possible_levels=possible_levels,
    finest_level=finest_level,
    check=check,
)
