"""Magnitude estimation of slipperiness (Biet 2007, Section IV-B, second experiment).

The surfaces, textures among them, come in random order; after exploring each, the participant
types how slippery it is. A trial that the operator voids, or (where the study says so) that times
out, is repeated at the end of its block under a number of its own.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Literal, Self

from pydantic import model_validator

from experiments.protocols.base import (
    Amplitude,
    AtLeastOne,
    Column,
    Context,
    Count,
    Flag,
    Positive,
    Protocol,
)
from experiments.protocols.pacing import PacedOptions
from experiments.randomisation import Rule, presentation_order
from experiments.steps import (
    Answer,
    Ask,
    EndTrial,
    Explore,
    Instruct,
    NumberQuestion,
    Phase,
    Present,
    Reply,
    Rest,
    Silence,
    Step,
    Steps,
    Trial,
    Voided,
)
from stimuli.texture import Grating

if TYPE_CHECKING:
    from collections.abc import Generator

    from stimuli.surface import Surface

TASK = "magnitudeestimation"


class MagnitudeEstimation(PacedOptions):
    """What a study may set for magnitude estimation, its pace apart.

    At the longest exploration the surface goes silent.

    Parameters
    ----------
    repetitions : int
        How often each surface is rated.
    practice : int
        How often each surface is rated before, for practice; recorded, not analysed.
    randomisation : {"simple", "blocked", "williams"}
        See `experiments.randomisation.presentation_order`.
    no_immediate_repeat : bool
        No surface follows itself.
    scale_top : {"none", "declared"}
        Whether the participant says beforehand what the most slippery surface would get.
    standard_um_pp, modulus : float
        A standard shown before each block, and the number it is given; both or neither (then the
        modulus is free).
    repeat_timed_out : bool
        Whether a timed-out trial is repeated, once.
    rest_every_trials : int
        Rest after so many trials; by default after each block.
    """

    repetitions: AtLeastOne = 1
    practice: Count = 1
    randomisation: Rule = "blocked"
    no_immediate_repeat: Flag = True
    scale_top: Literal["none", "declared"] = "none"
    standard_um_pp: Amplitude | None = None
    modulus: Positive | None = None
    repeat_timed_out: Flag = True
    rest_every_trials: AtLeastOne | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.standard_um_pp is None) != (self.modulus is None):
            raise ValueError("standard_um_pp and modulus go together: give both, or neither")
        return self


def trials(options: MagnitudeEstimation, context: Context) -> int:
    """Return how many trials a run has, practice included."""
    return len(context.surfaces) * (options.practice + options.repetitions)


def blocks(options: MagnitudeEstimation, context: Context) -> list[tuple[Phase, list[Surface]]]:
    """Return the order of surfaces, block by block, practice first."""
    surfaces = context.surfaces

    def order(phase: Phase, repetitions: int) -> list[tuple[Phase, list[Surface]]]:
        rule: Rule = "blocked" if phase == "practice" else options.randomisation
        drawn = presentation_order(
            len(surfaces),
            repetitions,
            rule,
            stream=context.stream(TASK, phase),
            row=context.row,
            no_immediate_repeat=options.no_immediate_repeat,
        )
        return [(phase, [surfaces[place] for place in block]) for block in drawn]

    practice = order("practice", options.practice) if options.practice else []
    return practice + order("main", options.repetitions)


def steps(options: MagnitudeEstimation, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    form = "instructions" if options.modulus is None else "instructions_standard"
    modulus = options.modulus or 0.0
    yield Instruct(
        title=texts["magnitude_estimation.title"],
        text=texts[f"magnitude_estimation.{form}"].format(
            modulus=f"{modulus:g}", twice=f"{2 * modulus:g}"
        ),
    )
    if options.scale_top == "declared":
        question = NumberQuestion(prompt=texts["magnitude_estimation.scale_top"], positive=True)
        yield Ask(name="scale_top", question=question, task=TASK)
    run = _Run(options, context)
    phase: Phase | None = None
    for block, (next_phase, surfaces) in enumerate(blocks(options, context), start=1):
        if options.practice and next_phase != phase:
            yield Instruct(text=texts[f"magnitude_estimation.{next_phase}"])
        elif block > 1 and options.rest_every_trials is None:
            yield run.rest()
        phase = next_phase
        yield from run.block(block, phase, surfaces)


class _Run:
    """The trials of a run, counted."""

    def __init__(self, options: MagnitudeEstimation, context: Context) -> None:
        self.options = options
        self.context = context
        self.total = trials(options, context)
        self.number = 0
        self.presented: dict[int, Surface] = {}

    def rest(self) -> Rest:
        """Return the break screen for now."""
        text = self.context.texts["session.rest"]
        return self.options.rest(text, done=self.number, total=self.total)

    def block(self, block: int, phase: Phase, surfaces: list[Surface]) -> Steps:
        """Yield a block: the standard if there is one, its trials, and what must be repeated."""
        if self.options.standard_um_pp is not None:
            yield from self.standard(self.options.standard_um_pp)
        queue: deque[tuple[Surface, int | None]] = deque((each, None) for each in surfaces)
        while queue:
            surface, repeats = queue.popleft()
            again = yield from self.trial(block, phase, surface, repeats)
            for number in again:
                self.total += 1
                queue.append((self.presented[number], number))
            every = self.options.rest_every_trials
            if every and self.number % every == 0 and self.number < self.total:
                yield self.rest()

    def standard(self, amplitude_um_pp: float) -> Steps:
        """Yield the standard, to be felt with the number that it is given."""
        text = self.context.texts["magnitude_estimation.standard"]
        yield Present(surface=self.context.surface(amplitude_um_pp))
        yield Explore(text=text.format(modulus=f"{self.options.modulus:g}"))
        yield Silence()

    def trial(
        self, block: int, phase: Phase, surface: Surface, repeats: int | None
    ) -> Generator[Step, Answer, list[int]]:
        """Yield one trial; return the numbers of the trials to be repeated."""
        options, texts = self.options, self.context.texts
        self.number += 1
        self.presented[self.number] = surface
        trial = Trial(
            task=TASK,
            number=self.number,
            total=self.total,
            phase=phase,
            factors={"block": block, "modulus": options.modulus},
            repeats=repeats,
        )
        yield Present(surface=surface, trial=trial)
        yield options.explore(texts["magnitude_estimation.explore"], trial)
        if options.exploration_maximum_s is not None:
            yield Silence(trial=trial)
        reply = yield Ask(
            name="estimate",
            question=NumberQuestion(prompt=texts["magnitude_estimation.estimate"]),
            trial=trial,
            time_limit_s=options.response_time_limit_s,
        )
        # Silence between surfaces: otherwise the change itself would be felt, not the surface.
        yield Silence(trial=trial)
        voided = yield EndTrial(trial=trial)
        again = list(voided.trials) if isinstance(voided, Voided) else []
        timed_out = isinstance(reply, Reply) and reply.timed_out
        if timed_out and options.repeat_timed_out and repeats is None and trial.number not in again:
            again.append(trial.number)
        return again


PROTOCOL = Protocol(
    task=TASK,
    title="Magnitude estimation of slipperiness",
    description=(
        "The participant strokes a vibrating plate and types a number that says how slippery it "
        "feels, on a scale of their own."
    ),
    options=MagnitudeEstimation,
    trials=trials,
    steps=steps,
    answer="estimate",
    instructions="magnitude_estimation.instructions",
    textures=True,
    columns={
        "texture": Column(
            value=lambda r: r.surface.name if isinstance(r.surface, Grating) else None,
            description=(
                "Name of the texture in the study file; n/a for a surface of one amplitude"
            ),
        ),
        "block": Column(
            value=lambda record: record.trial.factors["block"],
            description="Block of presentation, practice included, from 1",
        ),
        "estimate": Column(
            value=lambda record: record.answer("estimate"),
            description="Magnitude estimate of slipperiness as typed, on the participant's scale",
        ),
        "scale_top": Column(
            value=lambda record: record.run_answers.get("scale_top"),
            description=(
                "Number the participant would give to the most slippery surface imaginable, "
                "asked before the run"
            ),
        ),
        "modulus": Column(
            value=lambda record: record.trial.factors["modulus"],
            description="Number given to the standard; n/a with a free modulus",
        ),
    },
)
