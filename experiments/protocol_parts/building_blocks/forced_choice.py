"""Forced-choice trials, in which one of several intervals presents the target surface.

The threshold protocols share this code and define their own levels.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterable, Mapping
from dataclasses import replace
from typing import Literal, NamedTuple

from slipscale.experiments.languages.texts import answers
from slipscale.experiments.protocol_parts.adaptive.answered_tracks import AnsweredTracks
from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
from slipscale.experiments.protocol_parts.base import Context, Count, Positive
from slipscale.experiments.protocol_parts.building_blocks.adaptive_options import AdaptiveOptions
from slipscale.experiments.protocol_parts.building_blocks.comparing import IntervalTask, sought
from slipscale.experiments.protocol_parts.building_blocks.repeating import Repetition, part_over
from slipscale.experiments.protocol_parts.simulated_answers import SimulatedAnswer, as_asked
from slipscale.experiments.steps.columns import Column, TrialRecord, truth
from slipscale.experiments.steps.questions.base import Sought
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.rounding import rounded
from slipscale.experiments.steps.steps import Ask, EndTrial, Feedback, Instruct, Step, Steps
from slipscale.experiments.steps.trial import Phase, Trial, Value
from slipscale.faults.frozen_table import setting


class ForcedChoiceOptions(AdaptiveOptions):
    """Options for a forced-choice task with adaptive levels."""

    intervals: Literal[2, 3] = setting(
        2, "Number of surfaces in a trial, one of which is the target.", unit="intervals"
    )
    practice: Count = setting(
        3,
        "Number of practice trials at the highest level, before the main trials; recorded but not "
        "analysed.",
        unit="trials",
    )
    catch_trials: Count = setting(
        4,
        "Number of catch trials at the highest level, to check attention; the tracks ignore them.",
        unit="trials",
    )
    feedback: Literal["none", "practice", "always"] = setting(
        "practice", "When the participant learns whether the answer was correct."
    )
    feedback_s: Positive = setting(0.8, "Duration of the feedback.")

    @property
    def guess(self) -> float:
        """Expected proportion of correct answers from guessing."""
        return 1 / self.intervals


def intervals_of(options: ForcedChoiceOptions) -> int:
    """Return the number of intervals in a trial."""
    return options.intervals


class Choice(NamedTuple):
    """The definition of a trial: its phase, its level, and the track (if any) that chose it."""

    phase: Phase
    level: float
    track: int | None = None
    catch: bool = False
    repeats: int | None = None


class ForcedChoice(IntervalTask[Choice]):
    """One run of a forced-choice task.

    Parameters
    ----------
    options, context
        The run's options and context.
    texts : str
        Prefix of the task's text keys.
    standard_level : float
        Amplitude of the non-target surfaces, in µm peak to peak.
    sign : {1, -1}
        Whether the target is the standard plus (1) or minus (-1) the track's level.
    seeks : {"most", "least", "odd"}, optional
        Which surface the question asks for. By default, ``sign`` determines whether the question
        asks for the most or the least of the attribute (`comparing.sought`).
    """

    def __init__(
        self,
        options: ForcedChoiceOptions,
        context: Context,
        *,
        texts: str,
        standard_level: float,
        sign: int = 1,
        seeks: Sought | None = None,
    ) -> None:
        super().__init__(most_trials(options, context), options, context)
        self.options = options
        self._texts = texts
        self._standard_level = standard_level
        self._sign = sign
        self._seeks: Sought = seeks or sought(context.quantity, sign)
        start = options.begin(
            options.guess, lambda turn: context.stream(context.task, "tracks", turn)
        )
        self.tracks = AnsweredTracks(start)
        drawn = context.stream(context.task, "catch").shuffled(range(options.expected_trials))
        # Numbers of answers after which the catch trials are presented.
        self._catch_at = sorted(drawn[: options.catch_trials])
        self._missed = 0  # number of trials without an answer
        # Number of the trial that a track's next trial repeats, keyed by track.
        self._again: dict[int, int] = {}
        self._practice_left = options.practice
        self._repetitions_left = 0

    def steps(self) -> Steps:
        """Yield the steps of a run."""
        texts = self.context.texts
        yield Instruct(
            title=texts[f"{self._texts}.title"],
            text=texts[f"{self._texts}.instructions"].format(intervals=self.options.intervals),
        )
        if self.options.practice:
            yield Instruct(text=texts["comparing.practice"])
            easy = Choice("practice", self.options.highest_level)
            yield from self.block([easy] * self.options.practice)
            yield from self.close(lambda: Instruct(text=texts["comparing.main"]))
        yield from self.drawn(self.next)
        yield from self.close(lambda: part_over(texts))

    def next(self) -> Choice | None:
        """Return the definition of the next trial, or None when all tracks have ended."""
        now = self.tracks.now
        if now.over or self._missed >= now.most_trials:
            return None
        if self._catch_at and now.trials >= self._catch_at[0]:
            self._catch_at.pop(0)
            return Choice("main", self.options.highest_level, catch=True)
        repeats = self._again.pop(now.current, None)
        return Choice("main", now.level, now.current, repeats=repeats)

    def again(self, numbers: Iterable[int]) -> deque[Repetition[Choice]]:
        """Schedule repetitions of voided trials, at the next level of the track if there is one."""
        numbers = list(numbers)
        self.tracks.take_back(numbers)
        tracks = {number: self._known[number].track for number in numbers}
        self._again |= {track: number for number, track in tracks.items() if track is not None}
        others = super().again(number for number in numbers if tracks[number] is None)
        self._repetitions_left += len(others)
        self.total = self._total(self.tracks.now)
        return others

    def _total(self, now: Interleaved) -> int:
        """Return the largest possible number of trials, given the tracks' current state."""
        over = now.over or self._missed >= now.most_trials
        of_tracks = 0 if over else now.left_at_most + len(self._catch_at)
        return self.number + self._practice_left + self._repetitions_left + of_tracks

    def trial(
        self, condition: Choice, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        options, texts = self.options, self.context.texts
        if repeats is not None:
            self._repetitions_left -= 1
        elif condition.phase == "practice":
            self._practice_left -= 1
        target = self.context.stream(self.context.task, "place", number).below(options.intervals)
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors={
                "track": None if condition.track is None else condition.track + 1,
                "track_level": condition.level,
                "catch": condition.catch,
                "target_interval": target + 1,
            },
            repeats=condition.repeats if repeats is None else repeats,
        )
        for place in range(options.intervals):
            level = self._sign * condition.level if place == target else 0.0
            surface = self.context.surface(rounded(self._standard_level + level))
            yield from self.interval(surface, trial, place + 1)
        words = answers(texts["comparing.options"])[: options.intervals]
        reply = yield Ask(
            name="response",
            question=ComparisonQuestion(
                prompt=texts[f"{self._texts}.question"],
                options=tuple(words),
                seeks=self._seeks,
            ),
            trial=trial,
            time_limit_s=options.response_time_limit_s,
        )
        chosen = reply.value if isinstance(reply, Reply) else None
        correct = chosen == target + 1
        if chosen is not None and options.feedback in ("always", condition.phase):
            feedback = texts["forced_choice.right" if correct else "forced_choice.wrong"]
            yield Feedback(text=feedback, duration_s=options.feedback_s, trial=trial)
        return (yield from self.end(trial, condition, chosen, correct=correct))

    def end(
        self, trial: Trial, condition: Choice, chosen: Value, *, correct: bool
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """End a trial, update its track, and return the numbers of the trials to repeat."""
        number, now = trial.number, self.tracks.now
        if condition.track is not None and chosen is not None:
            now = now.answered(correct=correct)
        # Only the answer determines whether this trial is the last.
        reply = yield EndTrial(trial=replace(trial, total=self._total(now)))
        reply = reply if isinstance(reply, Voided) else Voided()
        voided, dropped = reply.trials, number in reply.dropped
        missed = (chosen is None or dropped) and number not in voided
        self._missed += missed
        if condition.track is not None and not missed and number not in voided:
            self.tracks.answer(number, correct=correct)
        # Unanswered trials of a track are repeated until `next` ends the block; other unanswered
        # trials are repeated once.
        comes_again = missed and not dropped
        comes_again &= condition.track is not None or trial.repeats is None
        return (*voided, number) if comes_again else voided


def most_trials(options: ForcedChoiceOptions, _context: Context) -> int:
    """Return the largest number of trials in a run, including practice and catch trials."""
    return options.practice + options.catch_trials + options.tracks * options.most_trials


def expected_trials(options: ForcedChoiceOptions, _context: Context) -> int:
    """Return the expected number of trials in a run."""
    return options.practice + options.catch_trials + options.expected_trials


def _correct(record: TrialRecord) -> str | None:
    chosen = record.answer("response")
    return None if chosen is None else truth(chosen == record.trial.factors["target_interval"])


DESIGN: Mapping[str, Column] = {
    "track": Column(
        description="Track that chose the level, numbered from 1; n/a in practice and catch trials"
    ),
    "catch": Column(
        kind="label",
        description="Whether the trial is a catch trial",
        levels={"true": "a trial at the highest level to check attention", "false": "none"},
    ),
}
STIMULUS: Mapping[str, Column] = {
    "track_level": Column(
        description="Difference between the target surface and the other surfaces{q.behind}",
        units="{q.bids}",
    ),
    "target_interval": Column(description="Interval that contained the target surface"),
}
RESPONSE: Mapping[str, Column] = {
    "response": Column(description="Interval that the participant chose"),
    "correct": Column(
        value=_correct,
        kind="label",
        description="Whether the chosen interval contained the target surface",
        levels={"true": "right", "false": "wrong"},
    ),
}
SIMULATED: Mapping[str, SimulatedAnswer] = {"response": as_asked}
