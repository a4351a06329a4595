"""A run's steps as they would come: to be looked at before anybody sits down.

Which steps come may depend on what is answered. A rehearsal therefore takes several ways through a
run, and a protocol says itself which amplitudes it could come to (`Protocol.possible_levels`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, assert_never

from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.participants.simulated_people.respondent import unanswered
from slipscale.experiments.protocols.ordering.randomisation import Stream
from slipscale.experiments.protocols.steps import (
    Adjust,
    Adjusted,
    Ask,
    ChoiceQuestion,
    ComparisonQuestion,
    EndBlock,
    EndTrial,
    Explore,
    Feedback,
    Instruct,
    NumberQuestion,
    Present,
    Presented,
    Reply,
    Rest,
    Silence,
    TextQuestion,
    VisualAnalogueQuestion,
    Voided,
    WholeNumberQuestion,
    YesNoQuestion,
)
from slipscale.experiments.study.headphone_test import HEADPHONES
from slipscale.faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from slipscale.experiments.protocols.steps import Answer, Question, Step, Steps, Value
    from slipscale.experiments.study.run_plan import RunPlan
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.surface import Surface

# An answer is the one at this place, from 0 to 1, among all that there are: the first is the first
# option and "yes". A way through a run is a place for each question, by the number of the question.
WAYS: Mapping[str, Callable[[int], float]] = {
    "first": lambda _: 0.0,
    "last": lambda _: 1.0,
    "in turn": lambda number: float(number % 2),
    "mixed": lambda number: Stream("rehearsal", number).uniform(),
}
FIRST = WAYS["first"]
# More steps than any trial, or any pause between trials, can have: a protocol repeats itself.
MOST_STEPS_OF_A_TRIAL = 1_000
MOST_STEPS_BETWEEN = 10_000


def bounded(steps: Steps, plan: RunPlan) -> Steps:
    """Return a run's steps, and refuse a protocol that goes on for ever without ending a trial.

    For runs that nobody watches. A person can be asked as often as a protocol wants.

    Raises
    ------
    UserError
        A trial has more steps than anybody would take.
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
                f"{where}: more than {count - 1:,} steps and no end; expected the protocol to end "
                "the trial (EndTrial) after a limited number of tries"
            )
        answer = yield step


def check_ways(plan: RunPlan) -> None:
    """Raise `UserError` if a protocol does what it did not declare, or never ends."""
    for way in WAYS.values():
        for _ in dry_run(plan, way):
            pass


def dry_run(plan: RunPlan, way: Callable[[int], float] = FIRST) -> Iterator[Step]:
    """Yield a run's steps as they come if every question is answered, and no trial voided.

    Parameters
    ----------
    plan : RunPlan
    way : callable
        Where in the range of answers each one is, by its number: 0 is "yes" and the first option.

    Raises
    ------
    UserError
        A protocol asks for an answer that its table has no column for, its table has a column
        that every task has, or it has more trials than it says.
    """
    quantity = plan.study.quantity
    declared = {protocol.task: columns(protocol, quantity=quantity) for protocol, _ in plan.tasks()}
    context = plan.context()
    most = {
        protocol.task: protocol.most(options, replace(context, task=protocol.task))
        for protocol, options in plan.tasks()
    }
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    # These have tables of their own, or none.
    beside = {HEADPHONES, *(each.name for each in plan.study.questionnaires)}
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
                    f"{named[task]} asks for '{step.name}', which its table has no column "
                    "for: the answer would be missing from the data set; expected it to be declared"
                )
        if isinstance(step, EndTrial) and step.trial.number > most[step.trial.task]:
            raise UserError(
                f"{named[step.trial.task]} goes on after {most[step.trial.task]} trials, the "
                "most that it says it has: a rule that never stops needs a cap"
            )
        yield step
        # Consent is given: without it nothing else would come. The operator decides to go on.
        own = isinstance(step, Ask) and step.trial is None and not step.task
        decided = isinstance(step, Ask) and step.by == "operator" and bool(step.task)
        answer = _answer(step, FIRST(asked) if own or decided else way(asked))


def _answer(step: Step, place: float) -> Answer:
    """Return the answer to a step at a place in the range of answers."""
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
        return Reply(value=_value(step.question, place))
    if isinstance(step, Instruct | Explore | Feedback | Rest):
        return Reply()
    assert_never(step)


def _value(question: Question, place: float) -> Value:
    if isinstance(question, YesNoQuestion):
        return place < 0.5  # noqa: PLR2004 - half of the range
    if isinstance(question, ChoiceQuestion | ComparisonQuestion):
        number = min(int(place * len(question.options)), len(question.options) - 1)
        chosen = question.options[number]
        return float(number + 1) if isinstance(question, ComparisonQuestion) else chosen[0]
    if isinstance(question, WholeNumberQuestion):
        return float(question.minimum + round(place * (question.maximum - question.minimum)))
    if isinstance(question, NumberQuestion):
        return 1.0 + place
    if isinstance(question, VisualAnalogueQuestion):
        return question.nearest(100.0 * place)
    if isinstance(question, TextQuestion):
        return "-"
    assert_never(question)


def surfaces(plan: RunPlan) -> list[Surface]:
    """Return every surface that a run could present, standards and starts among them, once each.

    They are in the order of their labels, so that the order of presentation stays unknown.

    Raises
    ------
    UserError
        A protocol presents an amplitude beyond those that it says it could.
    """
    found: set[Surface] = set()
    for protocol, options in plan.tasks():
        if protocol.possible_levels:
            context = plan.context(protocol.task)
            found |= {context.surface(each) for each in protocol.possible_levels(options, context)}
    for way in WAYS.values():
        found |= _on_a_way(plan, way)
    return sorted(found, key=lambda surface: (surface.label, surface.level))


def _on_a_way(plan: RunPlan, way: Callable[[int], float]) -> set[Surface]:
    """Return what is presented on a way through a run; refuse what a protocol did not declare."""
    bounds: dict[str, tuple[float, float]] = {}
    short = plan.study.quantity.short
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    for protocol, options in plan.tasks():
        if protocol.possible_levels:
            possible = list(protocol.possible_levels(options, plan.context(protocol.task)))
            bounds[protocol.task] = min(possible), max(possible)
    found: set[Surface] = set()
    for step in dry_run(plan, way):
        if isinstance(step, Present):
            found.add(step.surface)
            task = step.trial.task if step.trial else ""
            low, high = bounds.get(task, (0.0, float("inf")))
            if not low <= step.surface.level <= high:
                raise UserError(
                    f"{named[task]} presents {short(step.surface.level)}, and says "
                    f"that it presents {low:g} to {high:g}; expected it to declare every level"
                )
    return found


def check_supported(plan: RunPlan, plate: PlateDriver) -> None:
    """Raise `UserError`, or the plate's fault, if the plate could not present what a run needs."""
    for surface in surfaces(plan):
        plate.check_supported(surface, place_known=bool(plan.study.plate.position))
    q = plan.study.quantity
    for protocol, options in plan.tasks():
        if protocol.finest_level is None:
            continue
        finest_level, at_level = protocol.finest_level(options, plan.context(protocol.task))
        held_level = plate.limits.allowed_level(at_level)
        if finest_level < held_level:
            raise UserError(
                f"task '{protocol.task}' presents differences down to {q.short(finest_level)}, and "
                f"this plate is held to within {q.short(held_level)} at {q.short(at_level)}; "
                "present larger ones, or give the study's [plate] a tolerance and a "
                f"{q.named('tolerance_level')} that the plate can keep"
            )


def check_answered(plan: RunPlan) -> None:
    """Raise `UserError` where nobody could answer a question in a pilot."""
    answers = plan.simulated_answers()
    named = {protocol.task: protocol.named for protocol, _ in plan.tasks()}
    for way in WAYS.values():
        for step in dry_run(plan, way):
            if isinstance(step, Ask | Adjust):
                task = step.trial.task if step.trial else getattr(step, "task", "")
                if task and (task, step.name) not in answers:
                    raise UserError(unanswered(named[task], step.name))
