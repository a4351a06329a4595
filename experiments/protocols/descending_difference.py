"""The descending-difference protocol (Biet 2007, Section IV-B, first experiment).

The amplitude decreases in steps. After each step, the participant reports whether they feel a
difference and, if so, what has disappeared. In a catch step, nothing changes; without catch steps,
feeling a difference cannot be distinguished from a bias towards "yes". The study's textures are not
presented, because they cannot be ordered by amplitude.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

from slipscale.experiments.languages.texts import answers
from slipscale.experiments.protocol_parts.base import (
    Amplitude,
    AtLeastOne,
    Context,
    Count,
    Protocol,
    Switch,
)
from slipscale.experiments.protocol_parts.building_blocks.pacing import PacedOptions
from slipscale.experiments.protocol_parts.building_blocks.repeating import Repeating, part_over
from slipscale.experiments.protocol_parts.ordering.randomisation import with_catch_steps
from slipscale.experiments.protocol_parts.simulated_answers import as_asked
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.choice import ChoiceQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.steps import (
    Ask,
    EndTrial,
    Explore,
    Instruct,
    Present,
    Rest,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Trial
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.surface import Stimulus

TASK = "descendingdifference"


class DescendingDifference(PacedOptions):
    """Options for the descending-difference protocol, in addition to pacing."""

    series: AtLeastOne = setting(1, "Number of descending series.", unit="series")
    catch_steps: Count = setting(
        1,
        "Number of catch steps per series; in a catch step, the amplitude does not change.",
        unit="steps per series",
    )
    start_level: Amplitude | None = setting(
        None, "Starting amplitude of a series; default: the study's largest amplitude."
    )
    confidence: Switch = setting(False, "Whether to ask how certain the participant is.")


def descent(options: DescendingDifference, context: Context) -> list[float]:
    """Return the amplitudes of a series without its catch steps, in µm peak to peak."""
    falling = sorted(context.own_or_listed(None), reverse=True)
    start = falling[0] if options.start_level is None else options.start_level
    return [start, *(amplitude for amplitude in falling if amplitude < start)]


def trials(options: DescendingDifference, context: Context) -> int:
    """Return the number of steps in a run, including catch steps."""
    return options.series * (len(descent(options, context)) - 1 + options.catch_steps)


def steps(options: DescendingDifference, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    yield Instruct(
        title=texts["descending_difference.title"],
        text=texts["descending_difference.instructions"],
    )
    run = _Run(options, context)
    for series in range(1, options.series + 1):
        yield from run.series(series)
        yield from run.close(run.rest if series < options.series else run.part_over)


class _Step(NamedTuple):
    """The definition of a trial: its series and step, and the amplitudes in µm peak to peak."""

    series: int
    step: int
    before: float
    after: float


class _Run(Repeating[_Step]):
    def __init__(self, options: DescendingDifference, context: Context) -> None:
        super().__init__(trials(options, context))
        self.options = options
        self.context = context

    def explore(self, text: str, trial: Trial | None = None) -> Explore:
        """Return the exploration step for the current surface."""
        return self.options.explore(self.context.texts[f"descending_difference.{text}"], trial)

    def rest(self) -> Rest:
        """Return the break screen with the current progress."""
        text = self.context.texts["session.rest"]
        return self.options.rest(text, done=self.number, total=self.total)

    def part_over(self) -> Instruct:
        """Return the screen after the last series."""
        return part_over(self.context.texts)

    def series(self, series: int) -> Steps:
        """Yield one descending series."""
        falling = with_catch_steps(
            descent(self.options, self.context),
            self.options.catch_steps,
            self.context.stream(self.context.task, "catch", series),
        )
        yield Present(surface=self.context.surface(falling[0][0]))
        yield self.explore("start")
        yield from self.block(
            _Step(series, step, *amplitudes) for step, amplitudes in enumerate(falling, start=1)
        )

    def finish(self) -> Steps:
        """Switch the plate off at the end of a series; the plate stays on between steps."""
        yield Silence()

    def trial(
        self, condition: _Step, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield the steps of one trial, and return the numbers of the trials to repeat."""
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            factors={"series": condition.series, "step": condition.step},
            repeats=repeats,
        )
        # The participant has already felt this surface, unless a fault, a pause or a voided trial
        # intervened.
        lead_in = (Present(surface=self.context.surface(condition.before)), self.explore("start"))
        yield Present(surface=self.context.surface(condition.after), trial=trial, lead_in=lead_in)
        yield self.explore("explore", trial)
        yield from self.questions(trial)
        voided = yield EndTrial(trial=trial)
        return voided.trials if isinstance(voided, Voided) else ()

    def questions(self, trial: Trial) -> Steps:
        """Yield the questions that follow a step."""
        texts = self.context.texts
        reply = yield Ask(
            name="difference_felt",
            question=YesNoQuestion(prompt=texts["descending_difference.difference"]),
            trial=trial,
            time_limit_s=self.options.response_time_limit_s,
        )
        if isinstance(reply, Reply) and reply.value is True:
            prompt = texts["descending_difference.verbal_report"]
            yield Ask(name="verbal_report", question=TextQuestion(prompt=prompt), trial=trial)
        if self.options.confidence:
            words = answers(texts["descending_difference.confidence_options"])
            yield Ask(
                name="confidence",
                question=ChoiceQuestion(
                    prompt=texts["descending_difference.confidence"],
                    options=tuple((str(n), word) for n, word in enumerate(words, 1)),
                ),
                trial=trial,
            )


def _amplitude(surface: Stimulus | None) -> float | None:
    return None if surface is None else surface.level


def _catch(record: TrialRecord) -> str:
    return "true" if _amplitude(record.before) == _amplitude(record.surface) else "false"


def _felt(record: TrialRecord) -> str | None:
    answer = record.answer("difference_felt")
    return None if answer is None else "yes" if answer else "no"


def _amplitude_before(record: TrialRecord) -> float | None:
    return _amplitude(record.before)


PROTOCOL = Protocol(
    task=TASK,
    title="Descending difference",
    description=(
        "The plate's {q.name} decreases in steps. After each step, the participant reports "
        "whether they feel a difference and, if so, what has disappeared."
    ),
    options=DescendingDifference,
    trials=trials,
    steps=steps,
    answer="difference_felt",
    instructions="descending_difference.instructions",
    amplitudes=("start_level",),
    simulated={
        "difference_felt": as_asked,
        "verbal_report": as_asked,
        "confidence": as_asked,
    },
    design={
        "series": Column(description="Descending series, from 1"),
        "step": Column(
            description="Number of the step in its series, from 1; catch steps are counted"
        ),
    },
    stimulus={
        "level_before": Column(
            value=_amplitude_before,
            description="{q.in_full_title} before the step{q.behind}",
            units="{q.bids}",
        ),
    },
    response={
        "catch": Column(
            value=_catch,
            kind="label",
            description="Whether nothing changed at this step",
            levels={"true": "catch step: nothing changed", "false": "the {q.name} decreased"},
        ),
        "difference_felt": Column(
            value=_felt,
            kind="label",
            description="Whether the participant felt a difference",
            levels={"yes": "a difference was felt", "no": "no difference was felt"},
        ),
        "verbal_report": Column(
            kind="text",
            description="What the participant felt had been removed, in their own words",
        ),
        "confidence": Column(
            description="Certainty of the participant, from 1 (a guess) to 4 (certain)"
        ),
    },
)
