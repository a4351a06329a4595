"""Pointing (Fitts's task): fast movements to targets of different widths and distances.

Sequences follow ISO/TS 9241-411:2012. In one dimension, targets alternate between two bars; in two
dimensions, targets are opposite discs on a ring. Each movement begins when the participant selects
the start, so that an interruption never lengthens a movement time.

With feedback, the plate has one level on the target bar and another level elsewhere along the
stroke, and the finger's position must be measured. `slipscale.analysis.tasks.pointing` computes the
throughput.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from itertools import pairwise, product
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from slipscale.experiments.protocol_parts.base import (
    Amplitude,
    AtLeastOne,
    Context,
    Count,
    Options,
    Positive,
    Protocol,
    Seconds,
    Switch,
)
from slipscale.experiments.protocol_parts.building_blocks.repeating import Repeating, part_over
from slipscale.experiments.steps.columns import Column, TrialRecord
from slipscale.experiments.steps.questions.pointing import PointingQuestion, Selection
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import (
    Ask,
    EndTrial,
    Instruct,
    Present,
    Rest,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Phase, Trial, Value
from slipscale.faults import UserError
from slipscale.faults.frozen_table import setting
from slipscale.stimuli.surface import UNLISTED, Stimulus
from slipscale.stimuli.texture import Grating, bar

PLAIN, ON_TARGET, OUTSIDE = "none", "target", "outside"
#: Space for targets around the middle, in screen heights; texts are above and below.
HALF_WIDTH, HALF_HEIGHT = 0.63, 0.33
#: Feedback shortens movements by 9 % (Casiez and others 2011, CHI, Surfpad).
WITH_FEEDBACK = 0.91

FeedbackKind = Literal["none", "target"]
Lengths = Annotated[tuple[Positive, ...], Field(min_length=1, max_length=10)]


class Pointing(Options):
    """Options for pointing."""

    dimensions: Literal[1, 2] = setting(
        1,
        "1: two bars, which are reached in turn; 2: discs on a ring, each opposite the previous "
        "disc.",
        unit="dimensions",
    )
    distances_mm: Lengths = setting(
        (40.0, 80.0), "Distances between the centres of start and target."
    )
    widths_mm: Lengths = setting((4.0, 10.0), "Widths of the targets.")
    movements: AtLeastOne = setting(
        15,
        "Number of movements in a sequence at one distance and width; in two dimensions, an odd "
        "number that is also the number of discs.",
        unit="movements",
    )
    practice: Count = setting(
        5,
        "Number of practice movements to the easiest target; recorded but not analysed.",
        unit="movements",
    )
    feedback: Annotated[tuple[FeedbackKind, ...], Field(min_length=1)] = setting(
        ("none",),
        "Feedback conditions, each with every distance and width. none: the plate has "
        "ground_level everywhere; target: the plate has target_level on the target, which "
        "requires a measured position.",
    )
    ground_level: Amplitude = setting(
        0.0, "Level of the plate outside the target, or everywhere in trials without feedback."
    )
    target_level: Amplitude = setting(
        0.0, "Level of the plate inside the target, in trials with feedback."
    )
    screen_height_mm: Positive = setting(
        300.0,
        "Height of the participant's screen. With a position sensor: movement of the finger that "
        "corresponds to the height of the screen.",
    )
    response_time_limit_s: Positive | None = setting(
        None, "Time after which a movement counts as timed out; default: no limit."
    )
    repeat_timed_out: Switch = setting(True, "Whether a timed-out trial is repeated once.")
    rest_minimum_s: Seconds = setting(0.0, "Shortest rest between sequences.")

    @property
    def sequences(self) -> list[tuple[str, float, float]]:
        """All combinations of feedback, distance and width."""
        return list(product(self.feedback, self.distances_mm, self.widths_mm))


class Movement(NamedTuple):
    """The definition of a trial: one movement from a start to a target."""

    sequence: int
    phase: Phase
    feedback: str
    distance_mm: float
    width_mm: float
    start_mm: tuple[float, float]
    target_mm: tuple[float, float]


def check(options: Pointing, context: Context) -> None:
    """Raise `UserError` if the screen or the plate cannot present a target."""
    if context.varied is not None:
        raise UserError("pointing: vary is not supported; expected levels of the plate")
    if options.dimensions == 2 and not options.movements % 2:  # noqa: PLR2004
        raise UserError(
            "pointing: movements is {movements}, expected an odd number if dimensions = 2",
            movements=options.movements,
        )
    widest_mm = max(options.widths_mm)
    if widest_mm > min(options.distances_mm):
        raise UserError(
            "pointing: a target {widest_mm:g} mm wide overlaps the start, which is "
            "{nearest_mm:g} mm away; expected widths up to the smallest distance",
            widest_mm=widest_mm,
            nearest_mm=min(options.distances_mm),
        )
    room = (HALF_WIDTH if options.dimensions == 1 else HALF_HEIGHT) * options.screen_height_mm
    farthest_mm = _radius_mm(options, max(options.distances_mm)) + widest_mm / 2
    if farthest_mm > room:
        raise UserError(
            "pointing: targets reach {farthest_mm:.4g} mm from the middle, but the screen has "
            "room for {room:.4g} mm; use shorter distances or a larger screen_height_mm",
            farthest_mm=farthest_mm,
            room=room,
        )
    if len(set(options.feedback)) < len(options.feedback):
        raise UserError("pointing: feedback names a condition twice; expected different conditions")
    if ON_TARGET in options.feedback:
        if options.dimensions != 1:
            raise UserError(
                "pointing: feedback on the target requires movements in one dimension; expected "
                "dimensions = 1"
            )
        if options.target_level == options.ground_level:
            raise UserError(
                "pointing: {target_key} equals {ground_key}; feedback on the target requires two "
                "different levels",
                target_key=context.quantity.named("target_level"),
                ground_key=context.quantity.named("ground_level"),
            )


def trials(options: Pointing, _context: Context) -> int:
    """Return the number of trials in a run, including practice."""
    return options.practice + options.movements * len(options.sequences)


def steps(options: Pointing, context: Context) -> Steps:
    """Yield the steps of a run."""
    texts = context.texts
    yield Instruct(title=texts["pointing.title"], text=texts["pointing.instructions"])
    run = _Run(options, context)
    if options.practice:
        easiest = (options.feedback[0], min(options.distances_mm), max(options.widths_mm))
        yield Instruct(text=texts["pointing.practice"])
        yield from run.block(_movements(options, "practice", 1, easiest, options.practice))
        yield from run.close(lambda: Instruct(text=texts["pointing.main"]))
    order = context.stream(context.task, "sequences").shuffled(options.sequences)
    for number, condition in enumerate(order, start=1 + bool(options.practice)):
        yield from run.block(_movements(options, "main", number, condition, options.movements))
        last = number == len(order) + bool(options.practice)
        yield from run.close((lambda: part_over(texts)) if last else run.rest)


def _radius_mm(options: Pointing, distance_mm: float) -> float:
    """Return the distance from the middle at which opposite targets are ``distance_mm`` apart."""
    if options.dimensions == 1:
        return distance_mm / 2
    return distance_mm / (2 * math.cos(math.pi / (2 * options.movements)))


def _movements(
    options: Pointing, phase: Phase, number: int, condition: tuple[str, float, float], count: int
) -> list[Movement]:
    """Return the movements of a sequence; each movement starts at the previous target."""
    feedback, distance_mm, width_mm = condition
    radius_mm, ring = _radius_mm(options, distance_mm), options.movements
    if options.dimensions == 1:
        sides = [((-1) ** (place + 1) * radius_mm, 0.0) for place in range(count + 1)]
    else:
        turns = [place * (ring // 2) * 2 * math.pi / ring for place in range(count + 1)]
        sides = [
            (round(radius_mm * math.sin(turn), 6), round(radius_mm * math.cos(turn), 6))
            for turn in turns
        ]
    return [
        Movement(number, phase, feedback, distance_mm, width_mm, start, target)
        for start, target in pairwise(sides)
    ]


def target_surface(options: Pointing, movement: Movement) -> Grating:
    """Return the surface of a movement with feedback; the target is the only bar within reach."""
    return bar(
        ON_TARGET,
        label=UNLISTED,
        centre_mm=movement.target_mm[0],
        width_mm=movement.width_mm,
        on_level=options.target_level,
        off_level=options.ground_level,
        period_mm=2 * (movement.distance_mm + movement.width_mm),
    )


class _Run(Repeating[Movement]):
    def __init__(self, options: Pointing, context: Context) -> None:
        super().__init__(trials(options, context))
        self.options = options
        self.context = context

    def rest(self) -> Rest:
        """Return the rest break between sequences."""
        return Rest(
            text=self.context.texts["session.rest"],
            done=self.number,
            total=self.total,
            minimum_s=self.options.rest_minimum_s,
        )

    def trial(
        self, condition: Movement, number: int, repeats: int | None
    ) -> Generator[Step, Answer, tuple[int, ...]]:
        """Yield a movement's steps, and return the numbers of the trials to repeat."""
        options, texts = self.options, self.context.texts
        trial = Trial(
            task=self.context.task,
            number=number,
            total=self.total,
            phase=condition.phase,
            factors={
                "sequence": condition.sequence,
                "feedback": condition.feedback,
                "distance_mm": condition.distance_mm,
                "width_mm": condition.width_mm,
                "bars": options.dimensions == 1,
                **_places("start", condition.start_mm),
                **_places("target", condition.target_mm),
            },
            repeats=repeats,
        )
        yield Present(surface=self._surface(condition), trial=trial)
        question = PointingQuestion(
            prompt=texts["pointing.question"],
            start_mm=condition.start_mm,
            target_mm=condition.target_mm,
            width_mm=condition.width_mm,
            bars=options.dimensions == 1,
            screen_height_mm=options.screen_height_mm,
        )
        reply = yield Ask(
            name="selection",
            question=question,
            trial=trial,
            time_limit_s=options.response_time_limit_s,
        )
        yield Silence(trial=trial)
        voided = yield EndTrial(trial=trial)
        again = voided.trials if isinstance(voided, Voided) else ()
        missed = isinstance(reply, Reply) and reply.timed_out and number not in again
        return (
            (*again, number) if missed and options.repeat_timed_out and repeats is None else again
        )

    def _surface(self, condition: Movement) -> Stimulus:
        if condition.feedback == PLAIN:
            return self.context.surface(self.options.ground_level)
        return target_surface(self.options, condition)


def _places(name: str, centre_mm: tuple[float, float]) -> dict[str, Value]:
    return {f"{name}_{axis}_mm": value for axis, value in zip("xy", centre_mm, strict=True)}


def possible_levels(options: Pointing, _context: Context) -> tuple[float, ...]:
    """Return the plate's levels outside and on the target."""
    shown = options.target_level if ON_TARGET in options.feedback else options.ground_level
    return options.ground_level, shown


def _answer(step: Ask, person: SimulatedPerson) -> str:
    """Move as usual, or faster if the plate shows the target."""
    if step.trial is None:
        raise TypeError(f"'{step.name}' is not asked in a trial")
    feedback = WITH_FEEDBACK if step.trial.factors["feedback"] == ON_TARGET else 1.0
    question = step.of_kind(PointingQuestion)
    return question.moved(person.stream("movement"), person.pace * feedback).value


def _needs_position(options: Pointing) -> bool:
    return ON_TARGET in options.feedback


def _hit(record: TrialRecord) -> str | None:
    found, told = Selection.of(record.answer("selection")), record.trial.factors
    if found is None:
        return None
    x_mm, y_mm, width_mm = (
        float(told[name] or 0.0) for name in ("target_x_mm", "target_y_mm", "width_mm")
    )
    along_mm, across_mm = found.x_mm - x_mm, found.y_mm - y_mm
    away_mm = abs(along_mm) if told["bars"] else math.hypot(along_mm, across_mm)
    return ON_TARGET if away_mm <= width_mm / 2 else OUTSIDE


PROTOCOL = Protocol(
    task="pointing",
    title="Pointing",
    description=(
        "The participant moves as fast as possible from a start to a target and selects the "
        "target. Widths and distances of the targets differ between sequences."
    ),
    options=Pointing,
    trials=trials,
    steps=steps,
    answer="selection",
    instructions="pointing.instructions",
    simulated={"selection": _answer},
    design={
        "sequence": Column(
            description="Number of the movement sequence, from 1, including practice sequences"
        ),
        "feedback": Column(
            kind="label",
            description="Feedback by the plate",
            levels={
                PLAIN: "the same {q.name} everywhere",
                ON_TARGET: "another {q.name} on the target",
            },
        ),
    },
    stimulus={
        "distance_mm": Column(
            description="Distance between the centres of start and target", units="mm"
        ),
        "width_mm": Column(description="Width of the target", units="mm"),
        **{
            f"{name}_{axis}_mm": Column(
                description=(
                    f"Coordinate of the {name}'s centre relative to the middle of the screen, "
                    f"positive towards the {way}"
                ),
                units="mm",
            )
            for name in ("start", "target")
            for axis, way in (("x", "right"), ("y", "top"))
        },
    },
    response={
        "selection": Column(
            value=_hit,
            kind="label",
            description="Whether the participant selected the target",
            levels={ON_TARGET: "a position on the target", OUTSIDE: "another position"},
        ),
        **PointingQuestion.columns("selection"),
    },
    amplitudes=("target_level", "ground_level"),
    possible_levels=possible_levels,
    check=check,
    needs_position=_needs_position,
)
