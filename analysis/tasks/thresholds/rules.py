"""Reconstruct the adaptive rule that chose the levels of each task, from the study file."""

from __future__ import annotations

from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
from slipscale.experiments.protocol_parts.building_blocks.forced_choice import ForcedChoiceOptions
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError


def rules_of(study_text: str) -> dict[str, Interleaved]:
    """Return the initial state of the tracks of each adaptive task, keyed by task label.

    The result is empty if the study cannot be read.
    """
    found: dict[str, Interleaved] = {}
    try:
        study = parse_study(study_text, "code/study.toml")
    except UserError:
        return found
    for options in study.tasks:
        if isinstance(options, ForcedChoiceOptions):
            label = load_protocol(options.protocol).for_task(options).task
            # The order of the tracks does not affect the levels.
            found[label] = options.begin(options.guess, lambda turn: Stream(0, "rule", turn))
    return found
