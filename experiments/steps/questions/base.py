"""What every kind of question has in common.

A kind of question is one module with one class, derived from `Question`. The class contains the
question's data, the participant's screen, the operator's entry, simulated answers, the validation
and rehearsal of answers, and the columns for answers of several values. Shared code calls only the
methods below, and names no kind (`tests/experiments/steps/questions/test_kinds.py`). A question is
drawn from primitives (`slipscale.experiments.steps.screens.scene`), so it needs no window.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Literal, TypeVar

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.screens.asking import Asking
from slipscale.experiments.steps.screens.entry import Entry
from slipscale.experiments.steps.screens.scene import Scene
from slipscale.experiments.steps.screens.screen import Screen
from slipscale.experiments.steps.simulated_person import SimulatedPerson
from slipscale.experiments.steps.trial import Value

#: Which surface a comparison asks for; "odd" is the surface that differs from the others.
Sought = Literal["most", "least", "odd"]
# Name of the question about the participant's consent, whose answer is "yes" or "no".
CONSENT = "informed_consent"

T = TypeVar("T")


def is_number(value: object) -> bool:
    """Return whether a value is a finite number of 0 or more."""
    real = isinstance(value, int | float) and not isinstance(value, bool)
    return real and math.isfinite(float(str(value))) and float(str(value)) >= 0


def option_at(place: float, options: Sequence[T]) -> T:
    """Return the option at a position from 0 to 1."""
    return options[min(int(place * len(options)), len(options) - 1)]


@dataclass(frozen=True, slots=True, kw_only=True)
class Question(ABC):
    """Base class of all kinds of questions.

    A kind with an answer field implements `entry` and `body`. A kind with its own screen implements
    `screen`, and also `entry` if an operator can enter the answer.

    Attributes
    ----------
    EXPECTED : str
        Description of a valid answer, for messages.
    SPOKEN : bool
        Whether a participant can say the answer, which the operator then enters.
    """

    EXPECTED: ClassVar[str]
    SPOKEN: ClassVar[bool] = False
    prompt: str

    @abstractmethod
    def fits(self, value: object) -> bool:
        """Return whether a value is a valid answer."""

    @abstractmethod
    def rehearsed(self, place: float, /) -> Value:
        """Return an answer by its position in the range of answers; 0 is the first or "yes"."""

    def entry(self, _texts: Texts, /) -> Entry:
        """Return an empty answer field, for the participant's screen and the operator's answer."""
        raise TypeError(f"no answer field for {type(self).__name__}")

    def body(self, _entry: Entry, _texts: Texts, /) -> Scene:
        """Return the drawing of the answer field or keys."""
        raise TypeError(f"no drawing for {type(self).__name__}")

    def screen(self, texts: Texts, time_limit_s: float | None, back: bool, /) -> Screen:
        """Return the participant's screen.

        Parameters
        ----------
        texts : Mapping
            The texts in the participant's language.
        time_limit_s : float or None
            Time after which the screen ends with a time-out.
        back : bool
            Whether the participant can return to the previous question.
        """
        entry = self.entry(texts)
        return Asking(
            self.prompt,
            entry,
            partial(self.body, entry, texts),
            texts,
            time_limit_s=time_limit_s,
            back=back,
        )

    def simulated(self, _person: SimulatedPerson, name: str, /) -> Value:
        """Return a simulated participant's answer to the question called ``name``.

        Random numbers come only from ``person.stream(name, ...)``.
        """
        raise TypeError(f"no simulated answer to '{name}' ({type(self).__name__})")

    def movement_s(self, _value: Value, /) -> float:
        """Return the duration of the movement that an answer contains, 0 if it contains none."""
        return 0.0

    @classmethod
    def columns(cls, name: str, /) -> dict[str, Column]:  # noqa: ARG003 - for several values
        """Return the columns for the parts of an answer to the question called ``name``.

        By default, there are none: an answer is one value, which the protocol's column with the
        question's name contains.
        """
        return {}

    @property
    def listed(self) -> tuple[str, ...]:
        """Labels of the options among which an operator decides; empty for other questions."""
        return ()
