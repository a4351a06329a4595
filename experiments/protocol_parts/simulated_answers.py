"""Functions that answer a protocol's questions for simulated participants.

A protocol names the function that answers each question in a pilot (`base.Protocol.simulated`). The
function has access only to a `SimulatedPerson`, not to the protocol's plan or the correct answer.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from slipscale.experiments.steps.replies import FEEL_AGAIN, is_answer
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.steps import Adjust, Ask
from slipscale.experiments.steps.trial import Value

ASKS_AGAIN = 0.5  # assumed proportion of matches that repeat the reference before the end


#: A function that answers a question. For an `Adjust` step, the function is called after each notch
#: and returns 1 (up), -1 (down), 0 (done) or `FEEL_AGAIN`.
SimulatedAnswer = Callable[[Any, SimulatedPerson], "Value"]


def as_asked(step: Ask, person: SimulatedPerson) -> Value:
    """Answer as participants answer this kind of question, if nothing else is known about it."""
    return step.question.simulated(person, step.name)


def notices_difference(_step: Ask, person: SimulatedPerson) -> bool:
    """Answer whether two surfaces were different, based on the difference between impressions."""
    first, second = person.impressions
    return person.says_yes(abs(first - second))


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
        fits = is_answer(value) and step.question.fits(value)
        words = step.question.EXPECTED
    return None if fits else f"answered {value!r} to '{step.name}', expected {words}"
