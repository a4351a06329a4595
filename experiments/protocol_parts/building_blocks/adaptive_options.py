"""Options for the adaptive rule that selects the levels in a threshold task."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Literal

from pydantic import Field

from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved, Order
from slipscale.experiments.protocol_parts.adaptive.quest_plus import QuestPlus
from slipscale.experiments.protocol_parts.adaptive.staircase import staircase
from slipscale.experiments.protocol_parts.adaptive.stopping import MOST_TRIALS, Stopping
from slipscale.experiments.protocol_parts.adaptive.track import Track
from slipscale.experiments.protocol_parts.adaptive.up_down import Scale
from slipscale.experiments.protocol_parts.adaptive.weighted import weighted
from slipscale.experiments.protocol_parts.base import AtLeastOne, Positive, Switch
from slipscale.experiments.protocol_parts.building_blocks.pacing import RestedOptions
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.steps.rounding import rounded
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting

Rule = Literal["staircase", "weighted", "quest_plus"]
Some = Annotated[tuple[Positive, ...], Field(min_length=1)]
TrialCap = Annotated[int, Field(strict=True, ge=1, le=MOST_TRIALS)]


class AdaptiveOptions(RestedOptions):
    """Options for an adaptive rule and its levels; they apply to each track."""

    rule: Rule = setting(
        "staircase",
        "Rule that chooses the next level. staircase: one step down after down_after correct "
        "answers in a row, one step up after a wrong answer, with García-Pérez's step-size "
        "ratios; weighted: one step after every answer, with step sizes for which the "
        "proportion of correct answers converges to target; quest_plus: the level whose answer is "
        "expected to be most informative.",
    )
    start_level: Positive = setting(
        0.5, "Level of a track's first trial; quest_plus chooses this level itself."
    )
    lowest_level: Positive = setting(0.05, "Lowest level.")
    highest_level: Positive = setting(1.0, "Highest level.")
    down_after: Annotated[int, Field(strict=True, ge=1, le=4)] = setting(
        2, "Number of correct answers in a row before a step down in a staircase.", unit="answers"
    )
    target: Annotated[float, Field(strict=True, gt=0, lt=1)] = setting(
        0.75,
        "Proportion of correct answers to which a weighted rule converges.",
        unit="share, 0 to 1",
    )
    steps_up: Some = setting(
        (0.2, 0.1),
        "Sizes of steps up before the first reversal, after the first reversal, and so on; the "
        "last size is kept.",
        unit="decades, or µm peak to peak on the linear scale",
    )
    down_to_up: Positive | None = setting(
        None,
        "Size of a step down relative to a step up in a staircase; 1 gives equal steps, as in "
        "Levitt (1971). The default is García-Pérez's ratio for down_after.",
        unit="none",
    )
    until_first_error: Switch = setting(
        False,
        "Whether every correct answer in a staircase leads to a step down until the first error.",
    )
    scale: Scale = setting(
        "log10", "Whether steps multiply the level (log10) or add to the level (linear)."
    )
    quest_levels: AtLeastOne = setting(
        40,
        "Number of levels and of possible thresholds in quest_plus. The levels and thresholds are "
        "spaced logarithmically from the lowest to the highest level.",
        unit="levels",
    )
    quest_slopes: Some = setting(
        (1.0, 1.5, 2.0, 3.0, 5.0),
        "Candidate slopes of the Weibull function for quest_plus.",
        unit="none",
    )
    quest_lapses: Annotated[
        tuple[Annotated[float, Field(strict=True, gt=0, lt=0.5)], ...], Field(min_length=1)
    ] = setting((0.01, 0.04), "Candidate lapse rates for quest_plus.", unit="share, 0 to 1")
    tracks: Annotated[int, Field(strict=True, ge=1, le=8)] = setting(
        2, "Number of interleaved tracks, each with the same rule.", unit="tracks"
    )
    track_order: Order = setting(
        "shuffled",
        "Whether the tracks take turns in a fixed order (alternating) or in a new order in each "
        "round (shuffled).",
    )
    most_trials: TrialCap = setting(
        40, "Maximum number of answers per track.", unit="trials per track"
    )
    least_trials: TrialCap = setting(
        1,
        "Minimum number of answers before the option reversals or threshold_sd_log10 ends a track.",
        unit="trials per track",
    )
    reversals: AtLeastOne | None = setting(
        None,
        "Number of reversals after which a track ends; default: reversals do not end a track.",
        unit="reversals",
    )
    threshold_sd_log10: Positive | None = setting(
        None,
        "Posterior standard deviation of the threshold at which a quest_plus track ends; default: "
        "certainty does not end a track.",
        unit="decades",
    )

    def begin(self, guess: float, stream: Callable[[int], Stream]) -> Interleaved:
        """Return interleaved tracks in their initial state, before the first trial.

        Parameters
        ----------
        guess : float
            Expected proportion of correct answers from guessing.
        stream : callable
            Returns the random numbers for the track order in a round, given the round number.

        Raises
        ------
        UserError
            If the options contradict each other, a grid is too large, or a track could never end.
        """
        stopping = Stopping(
            most_trials=self.most_trials,
            least_trials=self.least_trials,
            reversals=self.reversals,
            threshold_sd_log10=self.threshold_sd_log10,
        )
        track = self._track(guess)
        return Interleaved.start((track,) * self.tracks, stopping, stream, self.track_order)

    @property
    def expected_trials(self) -> int:
        """Expected number of answers in all tracks; exact only if the number is fixed."""
        ruled = self.reversals is not None or self.threshold_sd_log10 is not None
        each = (self.least_trials + self.most_trials) // 2 if ruled else self.most_trials
        return self.tracks * each

    def _track(self, guess: float) -> Track:
        if self.rule == "quest_plus":
            return self._quest_plus(guess).start()
        if self.rule == "weighted":
            rule = weighted(
                start_level=self.start_level,
                lowest_level=self.lowest_level,
                highest_level=self.highest_level,
                steps_up=self.steps_up,
                target=self.target,
                scale=self.scale,
            )
        else:
            rule = staircase(
                start_level=self.start_level,
                lowest_level=self.lowest_level,
                highest_level=self.highest_level,
                steps_up=self.steps_up,
                down_after=self.down_after,
                scale=self.scale,
                down_to_up=self.down_to_up,
                until_first_error=self.until_first_error,
            )
        return rule.start()

    def _quest_plus(self, guess: float) -> QuestPlus:
        if self.highest_level <= self.lowest_level:
            raise UserError(
                "QUEST+: the highest level is {highest_level:g}, expected above the lowest "
                "({lowest_level:g})",
                highest_level=self.highest_level,
                lowest_level=self.lowest_level,
            )
        low, high = math.log10(self.lowest_level), math.log10(self.highest_level)
        spans = max(self.quest_levels - 1, 1)
        levels = tuple(
            rounded(10 ** (low + (high - low) * number / spans))
            for number in range(self.quest_levels)
        )
        return QuestPlus(
            levels=levels,
            threshold_levels=levels,
            slopes=self.quest_slopes,
            lapses=self.quest_lapses,
            guess=guess,
        )
