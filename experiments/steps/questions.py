"""Types of questions that a protocol can ask, with the values of their replies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple, Protocol, TypeVar

from slipscale.experiments.steps.trial import Value

#: Which surface a comparison asks for; "odd" is the surface that differs from the others.
Sought = Literal["most", "least", "odd"]
# Name of the question about the participant's consent, whose answer is "yes" or "no".
CONSENT = "informed_consent"


T = TypeVar("T")


class Draws(Protocol):
    """Random numbers, from which simulated participants draw answers about themselves."""

    def uniform(self) -> float:
        """Return a number from 0 up to, but not including, 1."""

    def choice(self, options: tuple[T, ...]) -> T:
        """Return one of the options."""


def is_number(value: object) -> bool:
    """Return whether a value is a finite number of 0 or more."""
    real = isinstance(value, int | float) and not isinstance(value, bool)
    return real and math.isfinite(float(str(value))) and float(str(value)) >= 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Question(ABC):
    """Base class of all kinds of questions.

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
    def rehearsed(self, place: float) -> Value:
        """Return an answer by its position in the range of answers; 0 is the first or "yes"."""

    def drawn(self, draws: Draws) -> Value:  # noqa: ARG002 - overridden if there is an answer
        """Return a simulated participant's answer to a question about the person."""
        raise TypeError(f"no simulated answer to {type(self).__name__}")

    def movement_s(self, value: Value) -> float:  # noqa: ARG002 - as above
        """Return the duration of the movement that an answer contains, 0 if it contains none."""
        return 0.0

    @property
    def listed(self) -> tuple[str, ...]:
        """Labels of the options among which an operator decides; empty for other questions."""
        return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberQuestion(Question):
    """Question answered with a number (0 or more, decimals allowed) on the participant's own scale.

    ``positive`` also excludes 0, for example for the top of a scale.
    """

    EXPECTED: ClassVar = "a number of 0 or more"
    SPOKEN: ClassVar = True
    positive: bool = False

    def fits(self, value: object) -> bool:
        """Return whether a value is a finite number of 0 or more."""
        return is_number(value)

    def rehearsed(self, place: float) -> Value:
        """Return a number from 1 to 2."""
        return 1.0 + place


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoQuestion(Question):
    """A yes/no question; the reply's value is a bool.

    For a comparison of surfaces, ``seeks`` specifies whether "yes" means more or less slippery.
    """

    #: Fields omitted from a record if they have their default value.
    LATER: ClassVar[tuple[str, ...]] = ("seeks",)
    EXPECTED: ClassVar = "true or false"
    seeks: Sought = "most"

    def fits(self, value: object) -> bool:
        """Return whether a value is a bool."""
        return isinstance(value, bool)

    def rehearsed(self, place: float) -> Value:
        """Return "yes" in the first half of the range."""
        return place < 0.5  # noqa: PLR2004 - half of the range


@dataclass(frozen=True, slots=True, kw_only=True)
class TextQuestion(Question):
    """A question with a free-text answer. The answer is stored verbatim."""

    EXPECTED: ClassVar = "a text"
    max_length: int = 200

    def fits(self, value: object) -> bool:
        """Return whether a value is a text."""
        return isinstance(value, str)

    def rehearsed(self, place: float) -> Value:  # noqa: ARG002 - every text is alike
        """Return a short text."""
        return "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceQuestion(Question):
    """Choice from ``options``, each of which is a pair of a code (for the data) and a label."""

    EXPECTED: ClassVar = "the code of one of the options"
    options: tuple[tuple[str, str], ...]

    def fits(self, value: object) -> bool:
        """Return whether a value is the code of an option."""
        return value in [code for code, _ in self.options]

    def rehearsed(self, place: float) -> Value:
        """Return the code of the option at a position."""
        return self.options[_index(place, len(self.options))][0]

    def drawn(self, draws: Draws) -> Value:
        """Return the code of a random option."""
        return draws.choice(self.options)[0]

    @property
    def listed(self) -> tuple[str, ...]:
        """Labels of the options."""
        return tuple(label for _, label in self.options)


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeNumberQuestion(Question):
    """Question answered with a whole number from ``minimum`` to ``maximum``, such as an age."""

    EXPECTED: ClassVar = "a whole number within the question's bounds"
    SPOKEN: ClassVar = True
    minimum: int
    maximum: int

    def fits(self, value: object) -> bool:
        """Return whether a value is a whole number within the bounds."""
        return is_number(value) and value in range(self.minimum, self.maximum + 1)

    def rehearsed(self, place: float) -> Value:
        """Return the whole number at a position between the bounds."""
        return float(self.minimum + round(place * (self.maximum - self.minimum)))

    def drawn(self, draws: Draws) -> Value:
        """Return a random number within the bounds."""
        span = self.maximum - self.minimum + 1
        return float(self.minimum + int(draws.uniform() * span))


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonQuestion(Question):
    """Question answered by choosing one of several surfaces; the reply's value is its number.

    ``options`` contains the labels on the screen, in the order of presentation ("the first", ...).
    ``seeks`` specifies whether the question asks for the most slippery, the least slippery or the
    odd surface.
    """

    EXPECTED: ClassVar = "the number of an interval"
    options: tuple[str, ...]
    seeks: Sought = "most"

    def fits(self, value: object) -> bool:
        """Return whether a value is the number of an interval."""
        return value in range(1, len(self.options) + 1)

    def rehearsed(self, place: float) -> Value:
        """Return the number of the interval at a position."""
        return float(_index(place, len(self.options)) + 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualAnalogueQuestion(Question):
    """Question answered by placing a mark on a line; the value is its position from 0 to 100.

    Parameters
    ----------
    prompt : str
        The question.
    left, right : str
        Labels at the left end (0) and the right end (100) of the line.
    resolution, key_step : float
        Distance between adjacent positions of the mark, and its movement per press of an arrow key.
    start : float
        Position of the mark before the first key press.
    start_shown : bool
        Whether the mark is visible (at ``start``) before the first key press or click.
    """

    EXPECTED: ClassVar = "a position on the line, 0 to 100"
    left: str
    right: str
    resolution: float
    key_step: float
    start: float
    start_shown: bool

    def nearest(self, place: float) -> float:
        """Return the position on the line nearest to ``place``, as a multiple of ``resolution``."""
        held = min(max(place, 0.0), 100.0)
        # The result is rounded, so that three steps of 0.1 are exactly 0.3.
        return round(round(held / self.resolution) * self.resolution, 6)

    def fits(self, value: object) -> bool:
        """Return whether a value is a position on the line, a multiple of ``resolution``."""
        return is_number(value) and value == self.nearest(float(str(value)))

    def rehearsed(self, place: float) -> Value:
        """Return the position on the line."""
        return self.nearest(100.0 * place)


class Selection(NamedTuple):
    """The position selected in a `PointingQuestion`, and the duration of the movement."""

    x_mm: float
    y_mm: float
    time_s: float

    @classmethod
    def of(cls, value: Value) -> Selection | None:
        """Parse the value of a reply, or return None if nothing was selected."""
        return cls(*map(float, value.split())) if isinstance(value, str) else None

    @property
    def value(self) -> str:
        """The selection as text, for `Reply.value`."""
        return " ".join(f"{number:.6f}" for number in self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointingQuestion(Question):
    """Question answered by pointing from a start to a target; the reply is a `Selection`.

    Parameters
    ----------
    prompt : str
        The instruction.
    start_mm, target_mm : tuple of float
        Centres of the start and the target relative to the middle of the screen; positive values
        are to the right and upwards.
    width_mm : float
        Width of each bar, or diameter of each disc.
    bars : bool
        If True, the start and the target are vertical bars, and only the horizontal position
        counts. If False, the start and the target are discs.
    screen_height_mm : float
        Movement in mm that corresponds to the height of the screen.
    """

    EXPECTED: ClassVar = "a selection"
    start_mm: tuple[float, float]
    target_mm: tuple[float, float]
    width_mm: float
    bars: bool
    screen_height_mm: float

    def holds(self, centre_mm: tuple[float, float], x_mm: float, y_mm: float) -> bool:
        """Return whether a position is within the bar or disc that is centred at ``centre_mm``."""
        x, y = centre_mm
        away_mm = abs(x_mm - x) if self.bars else math.hypot(x_mm - x, y_mm - y)
        return away_mm <= self.width_mm / 2

    def fits(self, value: object) -> bool:
        """Return whether a value is a selection."""
        return isinstance(value, str) and Selection.of(value) is not None

    def rehearsed(self, place: float) -> Value:
        """Return the middle of the target, reached after 1 to 2 s."""
        return Selection(*self.target_mm, time_s=1.0 + place).value

    def movement_s(self, value: Value) -> float:
        """Return the movement's duration; the time until then is the time to reach the start."""
        moved = Selection.of(value)
        return moved.time_s if moved else 0.0


def _index(place: float, count: int) -> int:
    """Return the index of the option at a position from 0 to 1."""
    return min(int(place * count), count - 1)
