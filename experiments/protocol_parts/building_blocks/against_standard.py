"""Trials in which surfaces are judged against a standard.

The standard is presented in each trial, as the first interval, or between trials: before the first
trial of a block, after each rest, and then after a fixed number of trials.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

from pydantic import Field

from slipscale.experiments.protocol_parts.base import Amplitude, AtLeastOne, Context, Count
from slipscale.experiments.protocol_parts.building_blocks.comparing import DESIGN
from slipscale.experiments.protocol_parts.building_blocks.rated_surfaces import (
    BLOCK,
    Presentation,
    RatedOptions,
    RatedSurfaces,
)
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.steps import Present, Silence, Steps
from slipscale.experiments.steps.trial import Trial
from slipscale.faults.frozen_table import setting

STANDARD, JUDGED = 1, 2


class StandardOptions(RatedOptions):
    """Options for tasks with a standard, in addition to order and pacing."""

    standard_level: Annotated[Amplitude, Field(gt=0)] = Field(
        description="Amplitude of the standard to which all surfaces are compared."
    )
    standard_every_trials: AtLeastOne = setting(
        1,
        "Number of trials after which the standard is presented again; with 1, every trial "
        "begins with the standard. With a larger number, the standard is also presented at the "
        "start of each block and after each rest.",
        unit="trials",
    )
    catch_trials: Count = setting(
        0,
        "Number of catch trials, whose correct answer is the standard itself; they check "
        "attention and are not analysed with the other trials.",
        unit="trials",
    )

    @property
    def in_each_trial(self) -> bool:
        """Whether each trial presents the standard in its first interval."""
        return self.standard_every_trials == 1


class AgainstStandard(RatedSurfaces):
    """One run of a task with a standard.

    Parameters
    ----------
    options, context
        The run's options and context.
    planned : sequence of sequence of Presentation
        Blocks of trials; practice blocks come first.
    words : str
        Text shown while the participant explores the standard.
    """

    def __init__(
        self,
        options: StandardOptions,
        context: Context,
        planned: Sequence[Sequence[Presentation]],
        words: str,
    ) -> None:
        super().__init__(options, context, planned)
        self.against = options
        self._words = words
        self._left = 0  # number of trials until the standard is due again

    def start(self) -> Steps:
        """Request the standard before the next trial."""
        self._left = 0
        yield from ()

    def between(self) -> Steps:
        """Yield a rest if one is due. The standard is then presented before the next trial."""
        if self.rest_due:
            self._left = 0
        yield from super().between()

    def standard(self, trial: Trial) -> Steps:
        """Yield the steps that present the standard, if the standard is due before this trial."""
        surface = self.context.surface(self.against.standard_level)
        if self.against.in_each_trial:
            yield Present(surface=surface, trial=trial, interval=STANDARD)
            yield self.order.explore(self._words, trial, interval=STANDARD)
            yield Silence(trial=trial, interval=STANDARD)
            return
        if not self._left:
            yield Present(surface=surface)
            yield self.order.explore(self._words)
            yield Silence()
            self._left = self.against.standard_every_trials
        self._left -= 1


DESIGN_COLUMNS: Mapping[str, Column] = {**BLOCK, **DESIGN}
STANDARD_COLUMN: Mapping[str, Column] = {
    "standard_level": Column(description="{q.title} of the standard{q.behind}", units="{q.bids}"),
}
