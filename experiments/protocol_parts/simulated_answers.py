"""Functions that answer a protocol's questions for simulated participants.

A protocol names the function that answers each question in a pilot (`base.Protocol.simulated`). The
function has access only to a `SimulatedPerson`, not to the protocol's plan or the correct answer.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.steps.questions import ComparisonQuestion
from slipscale.experiments.steps.replies import FEEL_AGAIN
from slipscale.experiments.steps.steps import Adjust, Ask
from slipscale.experiments.steps.trial import Value
from slipscale.faults import UserError

ASKS_AGAIN = 0.5  # assumed proportion of matches that repeat the reference before the end


class SimulatedPerson(Protocol):
    """Properties of a simulated participant that can influence simulated answers.

    All values depend on the seed, the participant, the trial and the plate's behaviour, never on
    the number of calls.
    """

    @property
    def language(self) -> str:
        """The language of verbal reports."""

    @property
    def scale_top(self) -> float:
        """The number that the person would give to the most slippery surface imaginable."""

    @property
    def rises(self) -> bool:
        """Whether the judged attribute increases with the level."""

    @property
    def pace(self) -> float:
        """The time that this person takes for an action, relative to the median person."""

    @property
    def turned(self) -> int:
        """Net number of notches turned so far in an `Adjust` step."""

    @property
    def felt_again(self) -> int:
        """Number of times that the reference was repeated in an `Adjust` step."""

    @property
    def felt_level(self) -> tuple[float, ...]:
        """The levels felt in this trial, µm peak to peak, in the order of its intervals."""

    @property
    def impressions(self) -> tuple[float, ...]:
        """Sensation strengths (0 to 100) in this trial, plus noise."""

    def usual(self, level: float) -> float:
        """Return the strength of sensation (0 to 100) that the person expects at a level."""

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the index of the strength that the person judges largest.

        The choice also depends on lapses and on a bias towards one of the intervals.
        """

    def says_yes(self, strength: float) -> bool:
        """Return whether a difference between impressions is large enough for the answer "yes"."""

    def estimate(self) -> float:
        """Return a magnitude estimate of the last surface, on this person's own scale."""

    def rating(self, start: float) -> float:
        """Return a rating of the last surface on a line from 0 to 100.

        ``start`` is the initial position of the mark, towards which some people's ratings are
        biased.
        """

    def ratio(self) -> float:
        """Return the strength of the last surface relative to the standard, above 0."""

    def reaches(self, ratio: float) -> bool:
        """Return whether the last surface is at least ``ratio`` times as strong as the standard."""

    def lapses(self) -> bool:
        """Return whether this person answers this question at random (a lapse)."""

    def notices(self) -> bool:
        """Return whether the person perceives a difference between the last two surfaces."""

    def verbal_report(self) -> str:
        """Return the person's verbal report of what disappeared when the level decreased."""

    def stream(self, *purpose: str | int) -> Stream:
        """Return the random number stream of this person and trial for a purpose."""


#: A function that answers a question. For an `Adjust` step, the function is called after each notch
#: and returns 1 (up), -1 (down), 0 (done) or `FEEL_AGAIN`.
SimulatedAnswer = Callable[[Any, SimulatedPerson], "Value"]


def compared(step: Ask, person: SimulatedPerson) -> float:
    """Answer a `ComparisonQuestion` with the interval that seemed most (or least) slippery."""
    question = step.question
    if not isinstance(question, ComparisonQuestion):
        raise UserError(
            "'{step_name}' does not compare surfaces; expected a ComparisonQuestion",
            step_name=step.name,
        )
    felt = person.impressions
    if question.seeks == "odd":
        total = sum(felt)
        return float(1 + person.pick([abs(len(felt) * each - total) for each in felt]))
    sign = 1 if question.seeks == "most" else -1
    return float(1 + person.pick([sign * each for each in felt]))


def notices_difference(_step: Ask, person: SimulatedPerson) -> bool:
    """Answer whether two surfaces were different, based on the difference between impressions."""
    first, second = person.impressions
    return person.says_yes(abs(first - second))


def any_choice(step: Ask, person: SimulatedPerson) -> Value:
    """Answer a `ChoiceQuestion` that has no correct answer by choosing a random option."""
    if isinstance(step.question, ComparisonQuestion):
        raise UserError(
            "'{step_name}' compares surfaces, so a pilot cannot answer it at random",
            step_name=step.name,
        )
    options = getattr(step.question, "options", ())
    chosen: str = person.stream(step.name).choice(options)[0]
    return chosen


def until_equal(step: Adjust, person: SimulatedPerson) -> int | str:
    """Adjust until the current surface seems equal to the surface felt first.

    If participants can feel the reference again, simulated participants do so once, before the end
    of a match, in half of the matches.
    """
    reference, now = (each if person.rises else -each for each in person.impressions)
    if step.again and not person.felt_again and _has_reached(reference, now, person.turned):
        return FEEL_AGAIN if person.stream("feel again").uniform() < ASKS_AGAIN else 0
    if person.turned == 0:
        return 1 if now < reference else -1 if now > reference else 0
    reached = _has_reached(reference, now, person.turned)
    return 0 if reached else 1 if person.turned > 0 else -1


def _has_reached(reference: float, now: float, turned: int) -> bool:
    return (turned > 0 and now >= reference) or (turned < 0 and now <= reference)


def until_number(step: Adjust, person: SimulatedPerson) -> int:
    """Adjust until the surface seems to reach the number shown, or the range ends."""
    number, modulus = (step.trial.factors[name] for name in ("number", "modulus"))
    if not (isinstance(number, float) and isinstance(modulus, float)):
        raise TypeError(f"'{step.name}' requires a trial with the factors 'number' and 'modulus'")
    beyond = person.reaches(number / modulus) is person.rises
    if person.turned == 0:
        return 0 if person.lapses() else -1 if beyond else 1
    up, now = person.turned > 0, person.felt_level[-1]
    end = step.highest_level if up else step.lowest_level
    if beyond is up or abs(now - end) < step.step_level / 2:
        return 0
    return 1 if up else -1


def _notches(step: Adjust, value: object) -> bool:
    whole = isinstance(value, int) and not isinstance(value, bool)
    return whole or (step.again is not None and value == FEEL_AGAIN)


def misfit(step: Ask | Adjust, value: object) -> str | None:
    """Return the reason why a value is not a valid answer, or None if the value is valid."""
    if isinstance(step, Adjust):
        fits, words = _notches(step, value), "a whole number of notches"
    else:
        fits, words = step.question.fits(value), step.question.EXPECTED
    return None if fits else f"answered {value!r} to '{step.name}', expected {words}"
