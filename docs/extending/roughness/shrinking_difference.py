"""Ask which of two surfaces is rougher, and reduce the difference after correct answers."""

from typing import NamedTuple

from pydantic import Field

from slipscale.protocol import (
    Amplitude,
    Ask,
    AtLeastOne,
    ChoiceQuestion,
    Column,
    ComparisonQuestion,
    EndTrial,
    Instruct,
    PacedOptions,
    Positive,
    Present,
    Protocol,
    Repeating,
    Silence,
    Trial,
    as_asked,
    part_over,
    rounded,
)

TEXTS = {
    "en": {
        "shrinking_difference.instructions": "You will feel two surfaces. Which one is rougher?",
        "shrinking_difference.stroke": "Surface {number}: stroke it.",
        "shrinking_difference.question": "Which one was rougher?",
        "shrinking_difference.first": "the first",
        "shrinking_difference.second": "the second",
        "shrinking_difference.sure": "Are you sure?",
        "shrinking_difference.yes": "yes",
        "shrinking_difference.no": "no",
    },
    "fr": {
        "shrinking_difference.instructions": (
            "Vous toucherez deux surfaces. Laquelle est la plus rugueuse ?"
        ),
        "shrinking_difference.stroke": "Surface {number} : caressez-la.",
        "shrinking_difference.question": "Laquelle était la plus rugueuse ?",
        "shrinking_difference.first": "la première",
        "shrinking_difference.second": "la deuxième",
        "shrinking_difference.sure": "En êtes-vous sûr ?",
        "shrinking_difference.yes": "oui",
        "shrinking_difference.no": "non",
    },
}


class ShrinkingDifference(PacedOptions):
    """Options that a study can set."""

    standard_level: Amplitude = Field(default=1.2, description="Amplitude of the smoother surface.")
    start_level: Positive = Field(default=0.8, description="First difference.")
    trials: AtLeastOne = Field(
        default=6, description="How many trials.", json_schema_extra={"unit": "trials"}
    )


class Pair(NamedTuple):
    """Condition of a trial: the difference between the surfaces, in µm peak to peak."""

    difference_level: float


class Run(Repeating[Pair]):
    """Count the trials of a run, and repeat trials that the operator voids."""

    def __init__(self, options, context):
        super().__init__(options.trials)
        self.options, self.context = options, context
        self.difference_level = options.start_level
        self.drawn_so_far = 0

    def next(self):
        """Return the condition of the next trial, or None after the last trial."""
        if self.drawn_so_far == self.options.trials:
            return None
        self.drawn_so_far += 1
        return Pair(self.difference_level)

    def trial(self, condition, number, repeats):
        """Yield the steps of one trial, and return the numbers of the trials to be repeated."""
        texts, options = self.context.texts, self.options
        rougher = 1 + self.context.stream(self.context.task, "place", number).below(2)
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            factors={"rougher": rougher},
            repeats=repeats,
        )
        for interval in (1, 2):
            # The more the plate vibrates, the smoother it feels.
            less = condition.difference_level if interval == rougher else 0.0
            surface = self.context.surface(rounded(options.standard_level - less))
            yield Present(surface=surface, trial=trial, interval=interval)
            stroke = texts["shrinking_difference.stroke"].format(number=interval)
            yield options.explore(stroke, trial, interval=interval)
            yield Silence(trial=trial, interval=interval)
        words = (texts["shrinking_difference.first"], texts["shrinking_difference.second"])
        question = ComparisonQuestion(
            prompt=texts["shrinking_difference.question"], options=words, seeks="least"
        )
        reply = yield Ask(name="chosen", question=question, trial=trial)
        certainty = ChoiceQuestion(
            prompt=texts["shrinking_difference.sure"],
            options=tuple((code, texts[f"shrinking_difference.{code}"]) for code in ("yes", "no")),
        )
        yield Ask(name="sure", question=certainty, trial=trial)
        voided = (yield EndTrial(trial=trial)).trials
        if number not in voided:
            factor = 0.7 if reply.value == rougher else 1.4
            self.difference_level = min(
                rounded(self.difference_level * factor), options.start_level
            )
        return voided


def steps(options, context):
    """Yield the steps of a run."""
    yield Instruct(text=context.texts["shrinking_difference.instructions"])
    run = Run(options, context)
    yield from run.drawn(run.next)
    yield from run.close(lambda: part_over(context.texts))


def right(record):
    """Return "true" if the rougher surface was chosen, else "false"; None without an answer."""
    chosen = record.answer("chosen")
    return None if chosen is None else str(chosen == record.trial.factors["rougher"]).lower()


PROTOCOL = Protocol(
    task="shrinkingdifference",
    title="Shrinking difference of roughness",
    description="Two surfaces are felt; the participant says which one was rougher, and how sure.",
    options=ShrinkingDifference,
    trials=lambda options, _context: options.trials,
    steps=steps,
    answer="chosen",
    instructions="shrinking_difference.instructions",
    simulated={"chosen": as_asked, "sure": as_asked},
    texts=TEXTS,
    stimulus={
        "rougher": Column(description="Interval that held the rougher surface"),
    },
    response={
        "chosen": Column(description="Interval that the participant chose"),
        "right": Column(
            value=right,
            kind="label",
            description="Whether the rougher surface was chosen",
            levels={"true": "right", "false": "wrong"},
        ),
        "sure": Column(
            kind="label",
            description="Whether the participant was sure",
            levels={"yes": "sure", "no": "not sure"},
        ),
    },
    intervals=lambda _options: 2,
    amplitudes=("standard_level", "start_level"),
    possible_levels=lambda options, _context: (
        options.standard_level,
        rounded(options.standard_level - options.start_level),
    ),
)
