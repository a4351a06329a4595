"""How a protocol has simulated participants answer its questions.

In a pilot nobody sits at the plate: for each of its questions a protocol names a function that says
what somebody answers who felt these surfaces (`base.Protocol.simulated`). What it may know of them
is `SimulatedPerson`, and no more: neither the protocol's plan nor which answer is right.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from slipscale.experiments.protocols.steps import (
    FEEL_AGAIN,
    Adjust,
    ChoiceQuestion,
    ComparisonQuestion,
    NumberQuestion,
    TextQuestion,
    VisualAnalogueQuestion,
    WholeNumberQuestion,
    YesNoQuestion,
)
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.protocols.ordering.randomisation import Stream
    from slipscale.experiments.protocols.steps import Ask, Value

ASKS_AGAIN = 0.5  # share of the matches before which the reference is felt again: our assumption


class SimulatedPerson(Protocol):
    """What a simulated participant is asked for by a protocol.

    All of it depends on (seed, participant, trial) and on what the plate did, never on how often
    something was called.
    """

    @property
    def language(self) -> str:
        """The language of verbal reports."""

    @property
    def scale_top(self) -> float:
        """What this person calls the most slippery surface imaginable."""

    @property
    def turned(self) -> int:
        """By how many notches the surface was turned, in an `Adjust`."""

    @property
    def felt_again(self) -> int:
        """How often the reference was felt again, in an `Adjust`."""

    @property
    def felt_level(self) -> tuple[float, ...]:
        """What was felt in this trial, µm peak to peak, in the order of its intervals."""

    @property
    def impressions(self) -> tuple[float, ...]:
        """How strong each of these seemed, 0 to 100, with the noise of the moment."""

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the place, from 0, of the strength that this person takes for the largest.

        Lapses and a liking for one of the intervals come in here.
        """

    def says_yes(self, strength: float) -> bool:
        """Return whether a difference of impressions is strong enough to say "yes" to."""

    def estimate(self) -> float:
        """Return a magnitude estimate of the surface felt last, on this person's own scale."""

    def rating(self, start: float) -> float:
        """Return where on a line of 0 to 100 this person puts the surface felt last.

        ``start`` is where the mark stood first: some are drawn to it.
        """

    def ratio(self) -> float:
        """Return how many times as strong as the standard the surface felt last is, above 0."""

    def reaches(self, ratio: float) -> bool:
        """Return whether the surface felt last is so many times as strong as the standard."""

    def lapses(self) -> bool:
        """Return whether this person attends to nothing in this question."""

    def notices(self) -> bool:
        """Return whether the two surfaces felt last seem different."""

    def verbal_report(self) -> str:
        """Return what this person says has been removed."""

    def stream(self, *purpose: str | int) -> Stream:
        """Return random numbers of this person's own for one purpose in this trial."""


#: Answers a question; for an `Adjust`, after each notch: 1 up, -1 down, 0 that will do, or
#: `FEEL_AGAIN`.
SimulatedAnswer = Callable[[Any, SimulatedPerson], "Value"]


def compared(step: Ask, person: SimulatedPerson) -> float:
    """Answer a `ComparisonQuestion` by the interval that seemed most, or least, slippery."""
    question = step.question
    if not isinstance(question, ComparisonQuestion):
        raise UserError(f"'{step.name}' compares nothing: expected a ComparisonQuestion")
    sign = 1 if question.seeks == "most" else -1
    return float(1 + person.pick([sign * each for each in person.impressions]))


def any_choice(step: Ask, person: SimulatedPerson) -> Value:
    """Answer a `ChoiceQuestion` by any of its options, where none is right."""
    if isinstance(step.question, ComparisonQuestion):
        raise UserError(f"'{step.name}' compares surfaces: a pilot cannot answer it by chance")
    options = getattr(step.question, "options", ())
    chosen: str = person.stream(step.name).choice(options)[0]
    return chosen


def until_equal(step: Adjust, person: SimulatedPerson) -> int | str:
    """Turn until the surface felt now seems to have reached the one felt first.

    Where that can be felt again, half of the times it is, before the last word.
    """
    reference, now = person.impressions
    if step.again and not person.felt_again and _has_reached(reference, now, person.turned):
        return FEEL_AGAIN if person.stream("feel again").uniform() < ASKS_AGAIN else 0
    if person.turned == 0:
        return 1 if now < reference else -1 if now > reference else 0
    reached = _has_reached(reference, now, person.turned)
    return 0 if reached else 1 if person.turned > 0 else -1


def _has_reached(reference: float, now: float, turned: int) -> bool:
    return (turned > 0 and now >= reference) or (turned < 0 and now <= reference)


def until_number(step: Adjust, person: SimulatedPerson) -> int:
    """Turn until the surface seems to have reached the number shown, or turns no further."""
    number, modulus = (step.trial.factors[name] for name in ("number", "modulus"))
    if not (isinstance(number, float) and isinstance(modulus, float)):
        raise TypeError(f"'{step.name}' shows no number and has no modulus")
    reached = person.reaches(number / modulus)
    if person.turned == 0:
        return 0 if person.lapses() else -1 if reached else 1
    up, now = person.turned > 0, person.felt_level[-1]
    end = step.highest_level if up else step.lowest_level
    if reached is up or abs(now - end) < step.step_level / 2:
        return 0
    return 1 if up else -1


def _number(_question: object, value: object) -> bool:
    real = isinstance(value, int | float) and not isinstance(value, bool)
    return real and math.isfinite(float(str(value))) and float(str(value)) >= 0


def _notches(step: Adjust, value: object) -> bool:
    whole = isinstance(value, int) and not isinstance(value, bool)
    return whole or (step.again is not None and value == FEEL_AGAIN)


#: Kind of question: what is an answer to it, and in words.
ANSWERS: Mapping[type, tuple[Callable[[Any, Any], bool], str]] = {
    NumberQuestion: (_number, "a number of 0 or more"),
    WholeNumberQuestion: (
        lambda question, value: (
            _number(question, value) and value in range(question.minimum, question.maximum + 1)
        ),
        "a whole number within the question's bounds",
    ),
    YesNoQuestion: (lambda _, value: isinstance(value, bool), "true or false"),
    TextQuestion: (lambda _, value: isinstance(value, str), "a text"),
    ChoiceQuestion: (
        lambda question, value: value in [code for code, _ in question.options],
        "the code of one of the options",
    ),
    ComparisonQuestion: (
        lambda question, value: value in range(1, len(question.options) + 1),
        "the number of an interval",
    ),
    VisualAnalogueQuestion: (
        lambda question, value: (
            _number(question, value) and value == question.nearest(float(value))
        ),
        "one of the line's places, 0 to 100",
    ),
    Adjust: (_notches, "a whole number of notches"),
}


def misfit(step: Ask | Adjust, value: object) -> str | None:
    """Return why a value is no answer to a question, None where it is one, or not known."""
    question = step if isinstance(step, Adjust) else step.question
    fits, words = ANSWERS.get(type(question), (lambda *_: True, ""))
    return None if fits(question, value) else f"answered {value!r} to '{step.name}', not {words}"
