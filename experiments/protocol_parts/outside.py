"""Report exceptions and invalid results of other packages' protocols as error messages.

This module wraps the functions that another package's protocol provides. Error messages then name
the package and the line.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING, Any, get_args

from slipscale.experiments.steps.questions.registry import watched
from slipscale.experiments.steps.steps import Ask, EndTrial, Step, Steps
from slipscale.experiments.steps.trial import Trial
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import called

if TYPE_CHECKING:
    from slipscale.experiments.protocol_parts.base import Context, Protocol
    from slipscale.experiments.steps.columns import Column
    from slipscale.experiments.steps.replies import Answer

STEPS = get_args(Step)
CELL = (str, int, float, bool, type(None))
OVER = object()


def guarded(protocol: Protocol, point: EntryPoint) -> Protocol:
    """Wrap the functions that another package's protocol provides."""
    named = protocol.named

    def watched(function: Callable[..., Any], what: str) -> Callable[..., Any]:
        return lambda *arguments: called(point, lambda: function(*arguments), f"{named}: {what}")

    def counted(function: Callable[..., Any], what: str) -> Callable[..., int]:
        def count(*arguments: Any) -> int:
            number: object = watched(function, what)(*arguments)
            if not isinstance(number, int) or isinstance(number, bool):
                raise UserError(
                    "{protocol}: {what} returned {number}, expected a whole number",
                    protocol=named,
                    what=what,
                    number=repr(number),
                )
            return number

        return count

    def columns(own: Mapping[str, Column]) -> dict[str, Column]:
        return {
            name: replace(column, value=_cell(watched, column, f"{named}: column '{name}'", name))
            for name, column in own.items()
        }

    optional: dict[str, Any] = {
        name: watched(getattr(protocol, name), name)
        for name in ("finest_level", "check", "needs_position")
        if getattr(protocol, name) is not None
    }
    if (possible := protocol.possible_levels) is not None:
        # A generator runs when it is converted to a tuple, so `watched` can report its exceptions.
        optional["possible_levels"] = watched(
            lambda *told: tuple(possible(*told)), "possible_levels"
        )
    if protocol.most_trials is not None:
        optional["most_trials"] = counted(protocol.most_trials, "most_trials")
    if callable(protocol.intervals):
        optional["intervals"] = counted(protocol.intervals, "intervals")
    return replace(
        protocol,
        trials=counted(protocol.trials, "trials"),
        steps=_steps(protocol, point),
        simulated={
            name: watched(answer, Message("the simulated answer to '{name}'", name=name))
            for name, answer in protocol.simulated.items()
        },
        design=columns(protocol.design),
        stimulus=columns(protocol.stimulus),
        response=columns(protocol.response),
        **optional,
    )


def _cell(
    watched: Callable[..., Callable[..., Any]], column: Column, subject: str, name: str
) -> Callable[..., Any]:
    value = watched(column.value, f"column '{name}'")

    def cell(record: object) -> Any:
        found = value(record)
        if not isinstance(found, CELL):
            raise UserError(
                "{subject} contains {name}, expected a string, a number, true, false or None",
                subject=subject,
                name=type(found).__name__,
            )
        return found

    return cell


def _steps(protocol: Protocol, point: EntryPoint) -> Callable[[Any, Context], Steps]:
    named = Message("{protocol}: its steps", protocol=protocol.named)
    make = protocol.steps

    def steps(options: Any, context: Context) -> Steps:
        own: object = called(point, lambda: make(options, context), named)
        if not isinstance(own, Generator):
            raise UserError(
                "{protocol} are of type {name}, expected a generator",
                protocol=named,
                name=type(own).__name__,
            )
        answer: Answer = None
        begun: Trial | None = None  # a trial that is not ended yet
        while True:
            step = called(point, lambda: _next(own, answer), named)  # noqa: B023 - called at once
            if step is OVER and begun is not None:
                raise UserError(
                    "{protocol} end without an EndTrial for trial {number}, so its answers would "
                    "be in no table; yield EndTrial(trial=trial) after the last answer",
                    protocol=named,
                    number=begun.number,
                )
            if step is OVER:
                return
            if not isinstance(step, STEPS):
                raise UserError(
                    "{protocol} contain an object of type {name}, expected one of {steps}",
                    protocol=named,
                    name=type(step).__name__,
                    steps=", ".join(kind.__name__ for kind in STEPS),
                )
            if isinstance(step, Ask):
                step = replace(step, question=watched(step.question, protocol.named))
            trial = getattr(step, "trial", None)
            begun = None if isinstance(step, EndTrial) else trial or begun
            answer = yield step

    return steps


def _next(own: Generator[object, Answer, None], answer: Answer) -> object:
    try:
        return own.send(answer)
    except StopIteration:
        return OVER
