"""Magnitude estimation of slipperiness (Biet 2007, Section IV-B, second experiment).

The surfaces, textures among them, come in random order; after exploring each, the participant
types how slippery it is. A trial that the operator voids, or (where the study says so) that times
out, is repeated at the end of its block under a number of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from pydantic import Field, ValidationInfo, field_validator

from experiments.protocols import orders_version_1
from experiments.protocols.base import (
    Amplitude,
    AtLeastOne,
    Column,
    Context,
    Count,
    Positive,
    Protocol,
    Switch,
)
from experiments.protocols.orders import Rule, practice_order, presentation_order
from experiments.protocols.pacing import PacedOptions
from experiments.protocols.repeating import Repeating, part_over
from experiments.protocols.steps import (
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
    """

    repetitions: AtLeastOne = Field(
        default=1,
        description="How often each surface is rated.",
        json_schema_extra={"unit": "ratings a surface"},
    )
    practice: Count = Field(
        default=1,
        description="How often each surface is rated before, for practice; recorded, not analysed.",
        json_schema_extra={"unit": "ratings a surface"},
    )
    randomisation: Rule = Field(
        default="blocked",
        description="Order of the surfaces. simple: all trials shuffled together; blocked: each "
        "repetition shuffled on its own; williams: rows of a Williams square, balanced for what "
        "follows what.",
    )
    no_immediate_repeat: Switch = Field(
        default=True,
        description="Whether orders in which a surface follows itself are avoided, from the last "
        "practice trial to the first main trial too.",
    )
    scale_top: Literal["none", "declared"] = Field(
        default="none",
        description="declared: the participant says beforehand which number the most slippery "
        "surface would get.",
    )
    standard_um_pp: Amplitude | None = Field(
        default=None,
        description="Amplitude of a standard that is presented before each block; left out: no "
        "standard, and the modulus is free. Goes together with modulus.",
    )
    modulus: Positive | None = Field(
        default=None,
        validate_default=True,
        description="Number that the standard is given. Goes together with standard_um_pp.",
        json_schema_extra={"unit": "the participant's scale"},
    )
    repeat_timed_out: Switch = Field(
        default=True, description="Whether a timed-out trial is repeated, once."
    )
    rest_every_trials: AtLeastOne | None = Field(
        default=None,
        description="A rest after so many trials; left out: after each block.",
        json_schema_extra={"unit": "trials"},
    )

    @field_validator("modulus")
    @classmethod
    def _with_its_standard(cls, value: float | None, info: ValidationInfo) -> float | None:
        if "standard_um_pp" in info.data and (value is None) != (
            info.data["standard_um_pp"] is None
        ):
            raise ValueError("standard_um_pp and modulus go together: give both, or neither")
        return value


def trials(options: MagnitudeEstimation, context: Context) -> int:
    """Return how many trials a run has, practice included."""
    return len(context.surfaces) * (options.practice + options.repetitions)


def blocks(options: MagnitudeEstimation, context: Context) -> list[tuple[Phase, list[Surface]]]:
    """Return the order of surfaces, block by block, practice first."""
    draw = _first_blocks if context.order_version == 1 else _blocks
    surfaces = context.surfaces
    return [
        (phase, [surfaces[each] for each in block])
        for phase, drawn in draw(options, context, len(surfaces)).items()
        for block in drawn
    ]


def _blocks(
    options: MagnitudeEstimation, context: Context, surfaces: int
) -> dict[Phase, list[list[int]]]:
    main = presentation_order(
        surfaces,
        options.repetitions,
        options.randomisation,
        stream=context.stream(context.task, "main"),
        shared=lambda group, turn: context.shared_stream(context.task, "main", group, turn),
        place=context.place,
        no_immediate_repeat=options.no_immediate_repeat,
    )
    practice = practice_order(
        surfaces,
        options.practice,
        stream=context.stream(context.task, "practice"),
        following=main[0][0] if options.no_immediate_repeat else None,
    )
    return {"practice": practice, "main": main}


def _first_blocks(
    options: MagnitudeEstimation, context: Context, surfaces: int
) -> dict[Phase, list[list[int]]]:
    """Return the order that version 1 drew."""

    def order(phase: Phase, repetitions: int, rule: Rule) -> list[list[int]]:
        return orders_version_1.presentation_order(
            surfaces,
            repetitions,
            rule,
            stream=context.stream(context.task, phase),
            row=context.row,
            no_immediate_repeat=options.no_immediate_repeat,
        )

    return {
        "practice": order("practice", options.practice, "blocked"),
        "main": order("main", options.repetitions, options.randomisation),
    }


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
        yield Ask(name="scale_top", question=question, task=context.task)
    run = _Run(options, context)
    planned = blocks(options, context)
    if options.practice:
        yield Instruct(text=texts["magnitude_estimation.practice"])
    for block, (phase, surfaces) in enumerate(planned, start=1):
        yield from run.block(_Presentation(block, phase, surface) for surface in surfaces)
        following = planned[block][0] if block < len(planned) else None
        if following is None:
            yield from run.close(lambda: part_over(texts))
        elif following != phase:
            yield from run.close(lambda: Instruct(text=texts["magnitude_estimation.main"]))
        elif options.rest_every_trials is None:
            yield from run.close(run.rest)


class _Presentation(NamedTuple):
    """What makes a trial: a surface, and the block and phase that it belongs to."""

    block: int
    phase: Phase
    surface: Surface


class _Run(Repeating[_Presentation]):
    """The trials of a run, counted."""

    def __init__(self, options: MagnitudeEstimation, context: Context) -> None:
        super().__init__(trials(options, context))
        self.options = options
        self.context = context

    def rest(self) -> Rest:
        """Return the break screen for now."""
        text = self.context.texts["session.rest"]
        return self.options.rest(text, done=self.number, total=self.total)

    def start(self) -> Steps:
        """Yield the standard before some trials, if there is one."""
        if self.options.standard_um_pp is not None:
            yield from self.standard(self.options.standard_um_pp)

    def between(self) -> Steps:
        """Yield the rest after so many trials."""
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
        self, condition: _Presentation, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield one trial; return the numbers of the trials to be repeated."""
        options, texts = self.options, self.context.texts
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors={"block": condition.block, "modulus": options.modulus},
            repeats=repeats,
        )
        yield Present(surface=condition.surface, trial=trial)
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
        again = voided.trials if isinstance(voided, Voided) else ()
        timed_out = isinstance(reply, Reply) and reply.timed_out
        if timed_out and options.repeat_timed_out and repeats is None and number not in again:
            again = (*again, number)
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
    amplitudes=("standard_um_pp",),
    textures=True,
    simulated={
        "estimate": lambda _, person: person.estimate(),
        "scale_top": lambda _, person: person.scale_top,
    },
    design={
        "block": Column(
            value=lambda record: record.trial.factors["block"],
            kind="number",
            description="Block of presentation, practice included, from 1",
        ),
    },
    stimulus={
        "texture": Column(
            value=lambda r: r.surface.name if isinstance(r.surface, Grating) else None,
            kind="label",
            description=(
                "Name of the texture in the study file; n/a for a surface of one amplitude"
            ),
        ),
    },
    response={
        "estimate": Column(
            value=lambda record: record.answer("estimate"),
            kind="number",
            description="Magnitude estimate of slipperiness as typed, on the participant's scale",
        ),
        "scale_top": Column(
            value=lambda record: record.run_answers.get("scale_top"),
            kind="number",
            description=(
                "Number the participant would give to the most slippery surface imaginable, "
                "asked before the run"
            ),
        ),
        "modulus": Column(
            value=lambda record: record.trial.factors["modulus"],
            kind="number",
            description="Number given to the standard; n/a with a free modulus",
        ),
    },
)
