"""Method of limits: levels move towards or away from a standard until the answer changes.

In each trial, the participant feels the standard, then a surface at some level, and answers whether
the two differ. An ascending series begins near the lowest level and ends with the first "yes". A
descending series begins near the highest level and ends with the first "no". The transition lies
between the last two levels of a series. Series begin at different levels, so that the number of
trials does not predict the transition.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterable
from typing import NamedTuple

from slipscale.experiments.protocol_parts.base import (
    Amplitude,
    AtLeastOne,
    Context,
    Count,
    Positive,
)
from slipscale.experiments.protocol_parts.base import Protocol as ProtocolDeclaration
from slipscale.experiments.protocol_parts.building_blocks.against_standard import STANDARD_COLUMN
from slipscale.experiments.protocol_parts.building_blocks.comparing import PAIR, IntervalTask
from slipscale.experiments.protocol_parts.building_blocks.pacing import RestedOptions
from slipscale.experiments.protocol_parts.building_blocks.repeating import Repetition, part_over
from slipscale.experiments.protocol_parts.simulated_answers import notices_difference
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.rounding import rounded
from slipscale.experiments.steps.steps import Ask, EndTrial, Instruct, Step, Steps
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting


class Limits(RestedOptions):
    """Options for the method of limits."""

    standard_level: Amplitude = setting(
        0.0, "Amplitude of the standard; for detection, 0 (the plate at rest)."
    )
    lowest_level: Amplitude = setting(
        0.05, "Lowest level, at which ascending series begin and descending series end."
    )
    highest_level: Positive = setting(
        0.6, "Highest level, at which descending series begin and ascending series end."
    )
    step_level: Positive = setting(0.05, "Distance between adjacent levels.")
    series: AtLeastOne = setting(
        4, "Number of series in each direction; directions alternate.", unit="series per direction"
    )
    start_steps: Count = setting(
        2,
        "Maximum number of levels between the end of the range and the start of a series; the "
        "number is drawn at random for each series.",
        unit="levels",
    )

    @property
    def each_level(self) -> tuple[float, ...]:
        """All levels, ascending."""
        last = int((self.highest_level - self.lowest_level) / self.step_level + 1e-9)
        return tuple(rounded(self.lowest_level + self.step_level * n) for n in range(last + 1))


class OneSeries(NamedTuple):
    """A series: its number (from 1), its direction, and its levels in order of presentation."""

    number: int
    ascending: bool
    levels: tuple[float, ...]


class Place(NamedTuple):
    """The definition of a trial: its series, its position there, and the trial that it repeats."""

    series: OneSeries
    place: int
    repeats: int | None


def check(options: Limits, context: Context) -> None:
    """Raise `UserError` if a series could contain only one level."""
    q, count, needed = context.quantity, len(options.each_level), options.start_steps + PAIR
    if count < needed:
        raise UserError(
            "{lowest_key} to {highest_key} has {count} levels; expected at least start_steps + "
            "{pair}, which is {needed}",
            lowest_key=q.named("lowest_level"),
            highest_key=q.named("highest_level"),
            count=count,
            pair=PAIR,
            needed=needed,
        )


def most_trials(options: Limits, _context: Context) -> int:
    """Return the largest number of trials in a run: all levels in every series."""
    return 2 * options.series * len(options.each_level)


def trials(options: Limits, context: Context) -> int:
    """Return the expected number of trials in a run, assuming half of the levels per series."""
    return max(most_trials(options, context) // 2, 1)


def possible_levels(options: Limits, _context: Context) -> tuple[float, ...]:
    """Return the amplitudes of the standard and of all levels."""
    return options.standard_level, *options.each_level


def finest_level(options: Limits, _context: Context) -> tuple[float, float]:
    """Return the difference between adjacent levels, and the highest amplitude in the task."""
    return options.step_level, max(options.standard_level, options.highest_level)


class _Run(IntervalTask[Place]):
    """One run of the method of limits.

    A voided trial is repeated together with all later trials of its series.
    """

    def __init__(self, options: Limits, context: Context) -> None:
        super().__init__(most_trials(options, context), options, context)
        self.options = options
        stream = context.stream(context.task, "series")
        begins = stream.below(2)
        self.series = [
            _series(options, number, stream.below(options.start_steps + 1), begins)
            for number in range(2 * options.series)
        ]
        self.answers: dict[int, list[tuple[int, bool]]] = {each.number: [] for each in self.series}
        self.missed = 0
        self.retaken: dict[int, int] = {}

    def steps(self) -> Steps:
        """Yield the steps of a run."""
        texts = self.context.texts
        yield Instruct(title=texts["limits.title"], text=texts["limits.instructions"])
        yield from self.drawn(self.next)
        yield from self.close(lambda: part_over(texts))

    def next(self) -> Place | None:
        """Return the next trial of the first unfinished series, or None at the end of the run."""
        for series in self.series:
            given = self.answers[series.number]
            turned = bool(given) and given[-1][1] is series.ascending
            if not turned and len(given) < len(series.levels) and self.missed < self.total:
                return Place(series, len(given), self.retaken.pop(series.number, None))
        return None

    def again(self, numbers: Iterable[int]) -> deque[Repetition[Place]]:
        """Discard voided trials and the later trials of their series, which are then repeated."""
        for number in numbers:
            series = self._known[number].series.number
            self.answers[series] = [each for each in self.answers[series] if each[0] < number]
            self.retaken[series] = number
        return deque()

    def trial(
        self, condition: Place, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a trial's steps, and return the numbers of the trials to repeat."""
        series, options = condition.series, self.options
        level = series.levels[condition.place]
        trial = Trial(
            task=self.context.task,
            number=number,
            total=max(self.total, number),
            factors={
                "series": series.number,
                "direction": "ascending" if series.ascending else "descending",
                "standard_level": options.standard_level,
                "comparison_level": level,
            },
            repeats=condition.repeats if repeats is None else repeats,
        )
        for place, shown in enumerate((options.standard_level, level), start=1):
            yield from self.interval(self.context.surface(shown), trial, place)
        reply = yield Ask(
            name="different",
            question=YesNoQuestion(prompt=self.context.texts["limits.question"]),
            trial=trial,
            time_limit_s=options.response_time_limit_s,
        )
        voided = yield EndTrial(trial=trial)
        again = voided.trials if isinstance(voided, Voided) else ()
        answered = reply.value if isinstance(reply, Reply) else None
        if isinstance(answered, bool):
            self.answers[series.number].append((number, answered))
        elif number not in again:
            self.missed += 1
            again = (*again, number)
        return again


def _series(options: Limits, number: int, start: int, begins: int) -> OneSeries:
    """Return series ``number``, counted from 0; series 0 is ascending if ``begins`` is 0."""
    ascending = (number + begins) % 2 == 0
    levels = options.each_level if ascending else options.each_level[::-1]
    return OneSeries(number + 1, ascending, levels[start:])


def steps(options: Limits, context: Context) -> Steps:
    """Yield the steps of a run."""
    yield from _Run(options, context).steps()


PROTOCOL = ProtocolDeclaration(
    task="limits",
    title="Method of limits",
    description=(
        "In ascending and descending series, the participant compares {q.levels} with a standard "
        "until the answer changes."
    ),
    options=Limits,
    trials=trials,
    most_trials=most_trials,
    steps=steps,
    answer="different",
    instructions="limits.instructions",
    simulated={"different": notices_difference},
    design={
        "series": Column(description="Series, from 1"),
        "direction": Column(
            kind="label",
            description="Direction of the series",
            levels={
                "ascending": (
                    'a series that begins near the lowest level and ends with the first "yes"'
                ),
                "descending": (
                    'a series that begins near the highest level and ends with the first "no"'
                ),
            },
        ),
    },
    stimulus={
        **STANDARD_COLUMN,
        "comparison_level": Column(
            description="{q.title} of the surface that was compared with the standard{q.behind}",
            units="{q.bids}",
        ),
    },
    response={
        "different": Column(
            kind="label",
            description="Whether the participant said that the surfaces were different",
            levels={"true": "different", "false": "the same"},
        ),
    },
    intervals=PAIR,
    amplitudes=("standard_level", "lowest_level", "highest_level", "step_level"),
    possible_levels=possible_levels,
    finest_level=finest_level,
    check=check,
)
