"""How a protocol has simulated participants answer its questions.

In a pilot nobody sits at the plate: for each of its questions a protocol names a function that says
what somebody answers who felt these surfaces (`base.Protocol.simulated`). What it may know of them
is `SimulatedPerson`, and no more: neither the protocol's plan nor which answer is right.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from experiments.protocols.steps import ComparisonQuestion
from faults import UserError

if TYPE_CHECKING:
    from experiments.protocols.randomisation import Stream
    from experiments.protocols.steps import Adjust, Ask, Value


class SimulatedPerson(Protocol):
    """What a simulated participant is asked for by a protocol.

    All of it depends on (seed, participant, trial) and on what the plate did, never on how often
    something was called.
    """

    language: str
    scale_top: float
    turned: int  # by how many notches, in an `Adjust`

    @property
    def felt_um_pp(self) -> tuple[float, ...]:
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

    def notices(self) -> bool:
        """Return whether the two surfaces felt last seem different."""

    def verbal_report(self) -> str:
        """Return what this person says has been removed."""

    def stream(self, *purpose: str | int) -> Stream:
        """Return random numbers of this person's own for one purpose in this trial."""


#: Answers a question; for an `Adjust`, after each notch: 1 up, -1 down, 0 that will do.
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


def until_equal(_step: Adjust, person: SimulatedPerson) -> int:
    """Turn until the surface felt now seems to have reached the one felt first."""
    reference, now = person.impressions
    if person.turned == 0:
        return 1 if now < reference else -1 if now > reference else 0
    reached = now >= reference if person.turned > 0 else now <= reference
    return 0 if reached else 1 if person.turned > 0 else -1
