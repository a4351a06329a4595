"""Options for the durations of exploration, answers and rests, shared by protocols."""

from __future__ import annotations

from pydantic import ValidationInfo, field_validator

from slipscale.experiments.protocol_parts.base import AtLeastOne, Options, Positive, Seconds
from slipscale.experiments.steps.steps import Explore, Rest
from slipscale.experiments.steps.trial import Trial
from slipscale.faults.frozen_table import setting


class PacedOptions(Options):
    """Options for all protocols in which participants explore and judge surfaces."""

    exploration_minimum_s: Seconds = setting(
        0.0, "Shortest time for stroking a surface before the question."
    )
    exploration_maximum_s: Positive | None = setting(
        None,
        "Longest time for stroking a surface, after which the question appears automatically; "
        "default: the participant decides.",
    )
    response_time_limit_s: Positive | None = setting(
        None, "Time after which the trial's main question counts as timed out; default: no limit."
    )
    rest_minimum_s: Seconds = setting(0.0, "Shortest rest between blocks.")

    @field_validator("exploration_maximum_s")
    @classmethod
    def _not_below_the_minimum(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is not None and value < info.data.get("exploration_minimum_s", 0.0):
            raise ValueError("expected no less than exploration_minimum_s")
        return value

    def explore(
        self, text: str, trial: Trial | None = None, *, interval: int | None = None
    ) -> Explore:
        """Return a step in which the participant explores the current surface."""
        return Explore(
            text=text,
            trial=trial,
            interval=interval,
            minimum_s=self.exploration_minimum_s,
            maximum_s=self.exploration_maximum_s,
        )

    def rest(self, text: str, *, done: int, total: int) -> Rest:
        """Return a rest step that shows ``done`` of ``total`` trials as completed."""
        return Rest(text=text, done=done, total=total, minimum_s=self.rest_minimum_s)


class RestedOptions(PacedOptions):
    """Options for a task with a rest after every fixed number of trials."""

    rest_every_trials: AtLeastOne = setting(25, "Number of trials between rests.", unit="trials")
