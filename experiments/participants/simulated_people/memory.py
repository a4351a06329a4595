"""Memory of a simulated person: the current trial and the finished steps.

A step is remembered only after its answer has been written to disk. A simulated person in a resumed
pilot therefore remembers the same steps as in an uninterrupted pilot.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING

from slipscale.experiments.participants.simulated_people.habits import History
from slipscale.experiments.steps.replies import Answer, Presented, Reply
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    EndBlock,
    EndTrial,
    Explore,
    Instruct,
    Present,
    Rest,
    Step,
)
from slipscale.stimuli.quantity import PLATE_AMPLITUDE
from slipscale.stimuli.varied import Varied

if TYPE_CHECKING:
    from slipscale.experiments.participants.simulated_people.population import Curves
    from slipscale.experiments.steps.trial import Trial


class Memory:
    """What one simulated person remembers during a run.

    Parameters
    ----------
    curves : Curves
        The population's mean sensations.
    """

    def __init__(self, curves: Curves) -> None:
        self._curves = curves
        # The protocol's current step. Any other step that a person performs repeats an earlier step
        # (for example, if a surface was lost) and has the same outcome as before.
        self.now: Step | None = None
        # The levels felt on the last two surfaces.
        self.felt = (0.0, 0.0)
        # The levels felt in one trial, by interval, and the current question.
        self.trial: Trial | None = None
        self.of_trial: dict[int, float] = {}
        self.standard_level = 0.0  # last level felt outside a trial
        self.turned = 0
        self.felt_again = 0
        self.question = ""
        self.again: tuple[str | int, ...] = ()
        # State that `over` updates after each finished step.
        self.trials = 0
        self._asked: Counter[tuple[str, int, str]] = Counter()
        self._histories: dict[str, History] = {}
        self._before: dict[str, float] = {}
        self._contact_s = 0.0

    @property
    def past(self) -> History:
        """The sensations in the current task so far, and the contact time since the last rest."""
        past = self._histories.get(self.trial.task, History()) if self.trial else History()
        return past.after_contact(self._contact_s)

    @property
    def last_level(self) -> float:
        """The level of the most recent surface in the trial or, outside a trial, in the run."""
        return self.of_trial[max(self.of_trial)] if self.of_trial else self.felt[1]

    @property
    def reference_level(self) -> float:
        """The level of the standard, felt at the start of this trial or before this trial."""
        several = len(self.of_trial) > 1
        return self.of_trial[min(self.of_trial)] if several else self.standard_level

    def begin(self, step: Ask | Explore | Adjust) -> None:
        """Begin a step. At the start of a new trial, forget the previous trial's impressions."""
        if step.trial != self.trial:
            self.trial, self.of_trial = step.trial, {}
            self.turned = self.felt_again = 0
        # Random numbers depend on the question's name, which must not depend on the quantity.
        self.question = "" if isinstance(step, Explore) else step.name
        if isinstance(step, Adjust):
            self.question = PLATE_AMPLITUDE.named(step.name)
        times = self._asked[_place(step)]
        if isinstance(step, Explore) and step is not self.now:
            times = max(times - 1, 0)
        interval = step.interval if isinstance(step, Explore) else None
        self.again = (
            *(() if interval is None else ("interval", interval)),
            *(("again", times) if times else ()),
        )

    def feels(self, step: Explore | Adjust, felt_level: float) -> None:
        """Store the level that the person felt, in µm peak to peak."""
        if isinstance(step, Explore):
            self.felt = (self.felt[1], felt_level)
        self.of_trial[step.interval or 1] = felt_level

    def over(self, step: Step, answer: Answer) -> None:
        """Remember a step after its answer was written to disk."""
        trial = step.trial
        if isinstance(step, Ask | Adjust | Explore):
            self._asked[_place(step)] += 1
        if isinstance(step, Explore):
            if isinstance(answer, Reply):
                self._contact_s += answer.response_time_s or 0.0
        elif isinstance(step, EndTrial):
            self.trials += 1
        elif isinstance(step, Instruct | Rest | EndBlock):
            self._contact_s = 0.0
        elif isinstance(step, Present) and isinstance(answer, Presented):
            varied = isinstance(step.surface, Varied)
            level = step.surface.level if varied else answer.commanded_level
            if trial is None:
                self.standard_level = level
                return
            self._histories[trial.task] = self._histories.get(trial.task, History()).with_trial(
                math.log(self._curves.mean(level)),
                self._before.get(trial.task, level),
            )
            self._before[trial.task] = level


def _place(step: Ask | Explore | Adjust) -> tuple[str, int, str]:
    """Return the key for counting a step: its task, its trial, and its question or interval."""
    name = f"explore {step.interval}" if isinstance(step, Explore) else step.name
    if step.trial:
        return step.trial.task, step.trial.number, name
    return step.task if isinstance(step, Ask) else "", 0, name
