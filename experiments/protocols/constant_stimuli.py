"""Constant stimuli: several fixed amplitudes are each compared equally often with a standard.

In the forced-choice form, the participant chooses the more slippery of two intervals; each
comparison surface comes first and second equally often. In the yes-no form, the comparison always
comes second, and the participant answers whether it was more slippery than the standard.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from slipscale.experiments.languages.texts import answers
from slipscale.experiments.protocol_parts.base import Amplitude, AtLeastOne, Context, Protocol
from slipscale.experiments.protocol_parts.building_blocks.comparing import (
    DESIGN,
    Comparing,
    ComparingOptions,
    Shown,
    sought,
    with_catch_trials,
)
from slipscale.experiments.protocol_parts.simulated_answers import as_asked
from slipscale.experiments.steps.columns import Column, TrialRecord, truth
from slipscale.experiments.steps.questions.base import Question
from slipscale.experiments.steps.questions.comparison import ComparisonQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Ask, Steps
from slipscale.experiments.steps.trial import Phase, Value
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting

FIRST, SECOND = 1, 2


class ConstantStimuli(ComparingOptions):
    """Options for constant stimuli."""

    standard_level: Amplitude = setting(1.2, "Amplitude of the standard.")
    comparison_levels: Annotated[tuple[Amplitude, ...], Field(min_length=1)] | None = setting(
        None,
        (
            "Amplitudes that are compared with the standard equally often; default: the study's "
            "amplitudes."
        ),
    )
    question: Literal["forced_choice", "yes_no"] = setting(
        "forced_choice",
        "forced_choice: which of two surfaces was more slippery; the comparison is presented first "
        "and second equally often. yes_no: whether the second surface, which is always the "
        "comparison, was more slippery.",
    )
    repetitions: AtLeastOne = setting(
        20, "Number of presentations per comparison.", unit="trials per comparison"
    )

    def comparisons(self, context: Context) -> tuple[float, ...]:
        """Return the amplitudes that are compared with the standard, µm peak to peak."""
        return context.own_or_listed(self.comparison_levels)

    def furthest_level(self, context: Context) -> float:
        """Return the comparison amplitude that differs most from the standard, µm peak to peak."""
        return max(self.comparisons(context), key=lambda each: abs(each - self.standard_level))


def check(options: ConstantStimuli, context: Context) -> None:
    """Raise `UserError` if comparisons are repeated, or if all comparisons equal the standard."""
    comparisons, key = options.comparisons(context), context.quantity.named("comparison_levels")
    if len(set(comparisons)) < len(comparisons):
        raise UserError("{key}: expected different amplitudes", key=key)
    if set(comparisons) == {options.standard_level}:
        raise UserError("{key}: expected amplitudes other than the standard", key=key)


def possible_levels(options: ConstantStimuli, context: Context) -> tuple[float, ...]:
    """Return the amplitudes of the standard and of all comparisons."""
    return options.standard_level, *options.comparisons(context)


def finest_level(options: ConstantStimuli, context: Context) -> tuple[float, float]:
    """Return the smallest difference from the standard, and the higher of the two amplitudes."""
    standard = options.standard_level
    others = [each for each in options.comparisons(context) if each != standard]
    nearest = min(others, key=lambda each: abs(each - standard))
    return abs(nearest - standard), max(nearest, standard)


def trials(options: ConstantStimuli, context: Context) -> int:
    """Return the number of trials in a run, including practice and catch trials."""
    main = options.repetitions * len(options.comparisons(context))
    return options.practice + options.catch_trials + main


def steps(options: ConstantStimuli, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    prompt = texts[f"constant_stimuli.{options.question}.question"]
    words = tuple(answers(texts["comparing.options"])[:SECOND])
    question: Question = (
        YesNoQuestion(prompt=prompt, seeks=sought(context.quantity))
        if options.question == "yes_no"
        else ComparisonQuestion(prompt=prompt, options=words, seeks=sought(context.quantity))
    )
    furthest = options.furthest_level(context)
    places = context.stream(context.task, "easy")

    def easy(phase: Phase, comparison: float) -> Shown:
        return _shown(options, context, phase, comparison, 1 + places.below(2), catch=True)

    # In the yes-no form, catch trials compare the standard with itself, so that "yes" indicates a
    # bias.
    caught = options.standard_level if options.question == "yes_no" else furthest
    run = Comparing(
        options,
        context,
        texts=f"constant_stimuli.{options.question}",
        question=question,
        practice=[easy("practice", furthest) for _ in range(options.practice)],
        main=with_catch_trials(
            _main(options, context),
            [easy("main", caught) for _ in range(options.catch_trials)],
            context.stream(context.task, "catch"),
        ),
    )
    yield from run.steps()


def _main(options: ConstantStimuli, context: Context) -> list[Shown]:
    """Return the main trials: each repetition contains all comparisons in a new random order."""
    comparisons = options.comparisons(context)
    stream = context.stream(context.task, "main")
    begins = [stream.below(2) for _ in comparisons]  # alternates between repetitions
    return [
        _shown(options, context, "main", comparisons[each], 1 + (begins[each] + repetition) % 2)
        for repetition in range(options.repetitions)
        for each in stream.shuffled(range(len(comparisons)))
    ]


def _shown(
    options: ConstantStimuli,
    context: Context,
    phase: Phase,
    comparison_level: float,
    place: int,
    *,
    catch: bool = False,
) -> Shown:
    """Return the definition of a trial.

    In the yes-no form, the comparison always comes second, whatever ``place`` is.
    """
    place = SECOND if options.question == "yes_no" else place
    pair = [context.surface(options.standard_level), context.surface(comparison_level)]
    return Shown(
        phase,
        tuple(pair if place == SECOND else pair[::-1]),
        {
            "standard_level": options.standard_level,
            "comparison_level": comparison_level,
            "comparison_interval": place,
            "catch": catch,
        },
    )


def _response(record: TrialRecord) -> str | None:
    """Return the answer as given: the number of an interval, "yes" or "no"."""
    answer = record.answer("response")
    if isinstance(answer, bool):
        return "yes" if answer else "no"
    return None if answer is None else f"{answer:g}"


def _comparison_more(record: TrialRecord) -> str | None:
    answer = record.answer("response")
    if isinstance(answer, bool):
        return truth(answer)
    place = record.trial.factors["comparison_interval"]
    return None if answer is None else truth(answer == place)


def _answer(step: Ask, person: SimulatedPerson) -> Value:
    if isinstance(step.question, YesNoQuestion):
        sign = 1 if step.question.seeks == "most" else -1
        return person.pick([sign * each for each in person.impressions]) == 1
    return as_asked(step, person)


PROTOCOL = Protocol(
    task="constantstimuli",
    title="Constant stimuli",
    description=(
        "Several fixed {q.levels} are each compared with a standard, all equally often. "
        "Participants report which of two surfaces was {q.more}, or whether the second surface "
        "was {q.more}."
    ),
    options=ConstantStimuli,
    trials=trials,
    steps=steps,
    answer="response",
    instructions="constant_stimuli.forced_choice.instructions",
    simulated={"response": _answer},
    design=DESIGN,
    stimulus={
        "standard_level": Column(
            description="{q.title} of the standard{q.behind}", units="{q.bids}"
        ),
        "comparison_level": Column(
            description="{q.title} of the comparison{q.behind}", units="{q.bids}"
        ),
        "comparison_interval": Column(description="Interval that contained the comparison"),
    },
    response={
        "response": Column(
            value=_response,
            kind="label",
            description="Original answer",
            levels={
                "1": "the first was {q.more}",
                "2": "the second was {q.more}",
                "yes": "the second surface was {q.more} than the first",
                "no": "the second was not {q.more}",
            },
        ),
        "comparison_more": Column(
            value=_comparison_more,
            kind="label",
            description="Whether the participant judged the comparison to be {q.more}",
            levels={"true": "the comparison", "false": "the standard"},
        ),
    },
    intervals=SECOND,
    amplitudes=("standard_level", "comparison_levels"),
    possible_levels=possible_levels,
    finest_level=finest_level,
    check=check,
)
