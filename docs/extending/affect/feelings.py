"""Ask how each surface feels, on an affect grid."""

from typing import NamedTuple

from affect_grid import AffectGrid

from slipscale.protocol import (
    Ask,
    AtLeastOne,
    Column,
    EndTrial,
    Instruct,
    PacedOptions,
    Present,
    Protocol,
    Repeating,
    Silence,
    Trial,
    as_asked,
    part_over,
    setting,
)

TEXTS = {
    "en": {
        "feelings.instructions": "You will feel several surfaces. How does each one feel to you?",
        "feelings.stroke": "Stroke the surface.",
        "feelings.question": "How does it feel?",
        "feelings.left": "unpleasant",
        "feelings.right": "pleasant",
        "feelings.bottom": "sleepy",
        "feelings.top": "excited",
        "feelings.how": "Choose a cell with the mouse or the arrow keys.",
    },
    "fr": {
        "feelings.instructions": "Vous toucherez plusieurs surfaces. Que ressentez-vous ?",
        "feelings.stroke": "Caressez la surface.",
        "feelings.question": "Que ressentez-vous ?",
        "feelings.left": "désagréable",
        "feelings.right": "agréable",
        "feelings.bottom": "endormi",
        "feelings.top": "excité",
        "feelings.how": "Choisissez une case avec la souris ou les flèches.",
    },
}
WORDS = ("left", "right", "bottom", "top", "how")


class Feelings(PacedOptions):
    """Options that a study can set."""

    repetitions: AtLeastOne = setting(2, "Presentations of each surface.", unit="trials")


class Shown(NamedTuple):
    """Condition of a trial: the surface's level."""

    level: float


class Run(Repeating[Shown]):
    """Count the trials of a run, and repeat trials that the operator voids."""

    def __init__(self, options, context):
        levels = list(context.levels) * options.repetitions
        super().__init__(len(levels))
        self.options, self.context = options, context
        self.order = iter(context.stream(context.task, "order").shuffled(levels))

    def next(self):
        """Return the condition of the next trial, or None after the last trial."""
        level = next(self.order, None)
        return None if level is None else Shown(level)

    def trial(self, condition, number, repeats):
        """Yield the steps of one trial, and return the numbers of the trials to be repeated."""
        texts = {key: self.context.texts[f"feelings.{key}"] for key in (*WORDS, "question")}
        task = self.context.task
        trial = Trial(task=task, number=number, total=self.total, repeats=repeats)
        yield Present(surface=self.context.surface(condition.level), trial=trial)
        yield self.options.explore(self.context.texts["feelings.stroke"], trial)
        question = AffectGrid(prompt=texts.pop("question"), **texts)
        yield Ask(name="feeling", question=question, trial=trial)
        yield Silence(trial=trial)
        return (yield EndTrial(trial=trial)).trials


def steps(options, context):
    """Yield the steps of a run."""
    yield Instruct(text=context.texts["feelings.instructions"])
    run = Run(options, context)
    yield from run.drawn(run.next)
    yield from run.close(lambda: part_over(context.texts))


PROTOCOL = Protocol(
    task="feelings",
    title="Feelings",
    description="The participant strokes a surface and rates valence and arousal on a grid.",
    options=Feelings,
    trials=lambda options, context: len(context.levels) * options.repetitions,
    steps=steps,
    answer="feeling",
    instructions="feelings.instructions",
    simulated={"feeling": as_asked},
    texts=TEXTS,
    response={
        "feeling": Column(description="Number of the chosen cell, from the lower left corner"),
        **AffectGrid.columns("feeling"),
    },
)
