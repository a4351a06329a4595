"""Step through a run in advance, without a participant, a plate or a screen.

Because the steps of a run can depend on the answers, several patterns of answers are tried, and
protocols declare the amplitudes that they may present (`Protocol.possible_levels`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import assert_never

from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.participants.simulated_people.respondent import unanswered
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.running.contact_sources import NOT_NAMED, ContactSpecs, of_run
from slipscale.experiments.steps.questions.base import is_number
from slipscale.experiments.steps.replies import (
    Adjusted,
    Answer,
    Presented,
    Reply,
    Voided,
    is_answer,
)
from slipscale.experiments.steps.steps import (
    Adjust,
    Ask,
    EndBlock,
    EndTrial,
    Explore,
    Feedback,
    Instruct,
    Present,
    Rest,
    Silence,
    Step,
    Steps,
)
from slipscale.experiments.steps.trial import Value
from slipscale.experiments.study.headphone_test import HEADPHONES
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.hardware.driver import PlateDriver
from slipscale.stimuli.surface import Stimulus

# An answer is specified by its position in the range of possible answers, from 0 to 1; 0 is the
# first option or "yes". Each function takes a question's number and returns its answer's position.
WAYS: Mapping[str, Callable[[int], float]] = {
    "first": lambda _: 0.0,
    "last": lambda _: 1.0,
    "in turn": lambda number: float(number % 2),
    "mixed": lambda number: Stream("rehearsal", number).uniform(),
}
FIRST = WAYS["first"]
# Maximum numbers of steps in a trial and between trials; a protocol that exceeds them is in an
# endless loop.
MOST_STEPS_OF_A_TRIAL = 1_000
MOST_STEPS_BETWEEN = 10_000


def bounded(steps: Steps, plan: RunPlan) -> Steps:
    """Yield a run's steps; raise an error if a trial has too many steps.

    The limit applies only to unsupervised runs, because a person may need many attempts.

    Raises
    ------
    UserError
        If a trial has too many steps.
    """
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    answer: Answer = None
    trial, count = None, 0
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return
        count = count + 1 if step.trial == trial else 1
        trial = step.trial
        if count > (MOST_STEPS_OF_A_TRIAL if trial else MOST_STEPS_BETWEEN):
            where = f"{named[trial.task]}, trial {trial.number}" if trial else "between trials"
            raise UserError(
                "{where}: not finished after {count:,} steps; expected the protocol to end the "
                "trial (EndTrial) after a limited number of attempts",
                where=where,
                count=count - 1,
            )
        answer = yield step


def check_ways(plan: RunPlan) -> None:
    """Raise `UserError` if a protocol violates its declaration or never ends."""
    for way in WAYS.values():
        for _ in dry_run(plan, way):
            pass


def dry_run(plan: RunPlan, way: Callable[[int], float] = FIRST) -> Iterator[Step]:
    """Yield a run's steps, assuming that all questions are answered and no trials are voided.

    Parameters
    ----------
    plan : RunPlan
    way : callable
        Pattern of answers: a function that takes the number of a question and returns the position
        of its answer, from 0 ("yes" or the first option) to 1 (the last option).

    Raises
    ------
    UserError
        If the protocol's table has no column for a question or redefines a common column, if
        there are more trials than declared, or if a question rejects its own answer.
    """
    quantity = plan.study.quantity
    declared = {protocol.task: columns(protocol, quantity=quantity) for protocol, _ in plan.tasks()}
    context = plan.context()
    most = {
        protocol.task: protocol.most(options, replace(context, task=protocol.task))
        for protocol, options in plan.tasks()
    }
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    # The answers to these questions are stored in a separate table or in no table.
    beside = {HEADPHONES, *(each.name for each in plan.study.questionnaires)}
    texts = plan.texts()
    steps = bounded(plan.steps(), plan)
    answer: Answer = None
    asked = 0
    while True:
        try:
            step = steps.send(answer)
        except StopIteration:
            return
        if isinstance(step, Ask | Adjust):
            asked += 1
            task = step.trial.task if step.trial else getattr(step, "task", "")
            if task and task not in beside and quantity.named(step.name) not in declared[task]:
                raise UserError(
                    "{named} asks for '{step_name}', but does not declare a column of this name: "
                    "the answer would be missing from the data set; declare the column",
                    named=named[task],
                    step_name=step.name,
                )
            if isinstance(step, Ask) and step.question.SPOKEN:
                step.question.entry(texts)
        if isinstance(step, EndTrial) and step.trial.number > most[step.trial.task]:
            raise UserError(
                "{named} continues after {most} trials, its declared maximum; add a limit to its "
                "stopping rule",
                named=named[step.trial.task],
                most=most[step.trial.task],
            )
        yield step
        # Questions such as consent, and the operator's decisions, are answered with the first
        # option, because other answers can end the run.
        own = isinstance(step, Ask) and step.trial is None and not step.task
        decided = isinstance(step, Ask) and step.by == "operator" and bool(step.task)
        answer = _answer(step, FIRST(asked) if own or decided else way(asked))


def _answer(step: Step, place: float) -> Answer:
    """Return an answer to a step; ``place`` is its position in the range of possible answers."""
    if isinstance(step, EndTrial | EndBlock):
        return Voided()
    if isinstance(step, Silence):
        return None
    if isinstance(step, Present):
        level = step.surface.level
        return Presented(
            commanded_level=level,
            readback_level=level,
            readback_kind="none",
            settled_by="time",
            onset_s=0.0,
        )
    if isinstance(step, Adjust):
        span_level = step.highest_level - step.lowest_level
        reached = step.highest_level - place * span_level
        return Adjusted(value=reached, readback_level=reached, trace=((0.0, reached),))
    if isinstance(step, Ask):
        return Reply(value=_judged(step, step.question.rehearsed(place)))
    if isinstance(step, Instruct | Explore | Feedback | Rest):
        return Reply()
    assert_never(step)


def _judged(step: Ask, value: Value) -> Value:
    """Return a question's own answer, which the question must accept."""
    question = step.question
    if not (is_answer(value) and question.fits(value)):
        raise UserError(
            "the question '{step_name}' ({kind}) rehearses the answer {value}; expected {expected}",
            step_name=step.name,
            kind=type(question).__name__,
            value=repr(value),
            expected=question.EXPECTED,
        )
    if not is_number(time_s := question.movement_s(value)):
        raise UserError(
            "the question '{step_name}' ({kind}) states a movement of {time_s} s; expected "
            "a number of seconds, 0 or more",
            step_name=step.name,
            kind=type(question).__name__,
            time_s=repr(time_s),
        )
    return value


def surfaces(plan: RunPlan) -> list[Stimulus]:
    """Return all possible surfaces of a run, including standards and start levels.

    The surfaces are sorted by label, so that the order of presentation is not revealed.

    Raises
    ------
    UserError
        If a protocol presents an amplitude outside its declared range.
    """
    found: set[Stimulus] = set()
    for protocol, options in plan.tasks():
        if protocol.possible_levels:
            context = plan.context(protocol.task)
            found |= {context.surface(each) for each in protocol.possible_levels(options, context)}
    for way in WAYS.values():
        found |= _on_a_way(plan, way)
    return sorted(found, key=lambda surface: (surface.label, surface.level))


def _on_a_way(plan: RunPlan, way: Callable[[int], float]) -> set[Stimulus]:
    """Return the surfaces of a dry run in which all answers follow one pattern."""
    bounds: dict[str, tuple[float, float]] = {}
    short = plan.study.quantity.short
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    for protocol, options in plan.tasks():
        if protocol.possible_levels:
            possible = list(protocol.possible_levels(options, plan.context(protocol.task)))
            bounds[protocol.task] = min(possible), max(possible)
    found: set[Stimulus] = set()
    for step in dry_run(plan, way):
        if isinstance(step, Present):
            found.add(step.surface)
            task = step.trial.task if step.trial else ""
            low, high = bounds.get(task, (0.0, float("inf")))
            if not low <= step.surface.level <= high:
                raise UserError(
                    "{named} presents {short}, but declares {low:g} to {high:g}; expected it to "
                    "declare every level",
                    named=named[task],
                    short=short(step.surface.level),
                    low=low,
                    high=high,
                )
    return found


def check_supported(plan: RunPlan, plate: PlateDriver, contact: ContactSpecs = NOT_NAMED) -> None:
    """Raise `UserError` or a plate fault if the plate cannot present every surface of a run.

    ``contact`` contains the sensors that the command names.
    """
    specs = of_run(contact, plan.study, plate.plate_file)
    for plate.second_level, surface in product((*plan.study.second_levels, 0.0), surfaces(plan)):
        plate.check_supported(surface.made, sensors=specs.used)
    for protocol, options in plan.tasks():
        if not protocol.needs_position(options):
            continue
        if "position" not in specs.used:
            raise UserError(
                "task '{task}' changes the plate's level at a certain position, so the finger "
                "position must be measured; name a sensor ([plate] position, or --position)",
                task=protocol.task,
            )
        if plate.follow_lag_s is None:
            raise UserError(
                "task '{task}' changes the plate's level at a certain position, but this plate "
                "cannot follow the finger; use a driver board",
                task=protocol.task,
            )
    q = plan.study.quantity
    if q.unit_in_full != plan.study.plate_quantity.unit_in_full:
        return  # The plate's tolerance does not apply to parameters such as periods and speeds.
    for protocol, options in plan.tasks():
        if protocol.finest_level is None:
            continue
        context = plan.context(protocol.task)
        finest_level, at_level = protocol.finest_level(options, context)
        held_level = plate.limits.allowed_level(context.surface(at_level).settled_level)
        if finest_level < held_level:
            raise UserError(
                "task '{task}' presents differences down to {finest_level}, but the plate's "
                "tolerance is {held_level} at {at_level}; present larger differences, or give "
                "the study's [plate] a tolerance and a {named} that the plate can keep",
                task=protocol.task,
                finest_level=q.short(finest_level),
                held_level=q.short(held_level),
                at_level=q.short(at_level),
                named=q.named("tolerance_level"),
            )


def check_answered(plan: RunPlan) -> None:
    """Raise `UserError` if simulated participants cannot answer a question."""
    answers = plan.simulated_answers()
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    for way in WAYS.values():
        for step in dry_run(plan, way):
            if isinstance(step, Ask | Adjust):
                task = step.trial.task if step.trial else getattr(step, "task", "")
                if task and (task, step.name) not in answers:
                    raise UserError(unanswered(named[task], step.name))
