"""The kinds of question that a protocol can ask, and the value of a reply to each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

if TYPE_CHECKING:
    from slipscale.experiments.steps.trial import Value

#: What a comparison asks for; odd: the one that differs from the others.
Sought = Literal["most", "least", "odd"]
# Name of the question that asks for the participant's consent: "yes" or "no".
CONSENT = "informed_consent"


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberQuestion:
    """Any number of 0 or more, decimals allowed, on the participant's own scale.

    ``positive`` also excludes 0 (the top of a scale cannot be 0).
    """

    prompt: str
    positive: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoQuestion:
    """Yes or no; the reply's value is a bool.

    In a comparison, ``seeks`` selects whether yes means the more or the less slippery surface.
    """

    #: Omitted from a record if it has its default value.
    LATER: ClassVar[tuple[str, ...]] = ("seeks",)
    prompt: str
    seeks: Sought = "most"


@dataclass(frozen=True, slots=True, kw_only=True)
class TextQuestion:
    """Free text, stored verbatim."""

    prompt: str
    max_length: int = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceQuestion:
    """A choice from a few ``options``: pairs of code (for the data) and words (on the screen)."""

    prompt: str
    options: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeNumberQuestion:
    """A whole number from ``minimum`` to ``maximum``, both included, such as an age in years."""

    prompt: str
    minimum: int
    maximum: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonQuestion:
    """Asks which of the presented surfaces fits; the reply's value is its number, 1, 2, ...

    ``options`` are the words on the screen, in the order of presentation ("the first", ...).
    ``seeks`` selects whether the question asks for the most slippery, the least slippery or the
    odd surface.
    """

    prompt: str
    options: tuple[str, ...]
    seeks: Sought = "most"


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualAnalogueQuestion:
    """A mark on a line between two words; the value is its position, 0 (left) to 100 (right).

    Parameters
    ----------
    prompt : str
        The question.
    left, right : str
        The words at the line's ends.
    resolution, key_step : float
        Distance between possible positions of the mark, and its movement per arrow key press.
    start : float
        The position from which keys move the mark.
    start_shown : bool
        Whether the mark is shown there before the first press or click.
    """

    prompt: str
    left: str
    right: str
    resolution: float
    key_step: float
    start: float
    start_shown: bool

    def nearest(self, place: float) -> float:
        """Return the nearest possible position of the mark, limited to the ends of the line."""
        held = min(max(place, 0.0), 100.0)
        # Rounded, so that three tenths are exactly 0.3.
        return round(round(held / self.resolution) * self.resolution, 6)


class Selection(NamedTuple):
    """Where a `PointingQuestion` was answered, and how long the movement from the start took."""

    x_mm: float
    y_mm: float
    time_s: float

    @classmethod
    def of(cls, value: Value) -> Selection | None:
        """Return the selection in a reply's value; None if there was none."""
        return cls(*map(float, value.split())) if isinstance(value, str) else None

    @property
    def value(self) -> str:
        """The reply's value."""
        return " ".join(f"{number:.6f}" for number in self)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointingQuestion:
    """A movement from a start to a target on the screen; the value is a `Selection`.

    Parameters
    ----------
    prompt : str
        The instruction.
    start_mm, target_mm : tuple of float
        Centres, from the middle of the screen to the right and up.
    width_mm : float
        Width of a bar or diameter of a disc.
    bars : bool
        Whether start and target are vertical bars, so that only the horizontal position matters.
    screen_height_mm : float
        Height of the screen in the plane of the movement.
    """

    prompt: str
    start_mm: tuple[float, float]
    target_mm: tuple[float, float]
    width_mm: float
    bars: bool
    screen_height_mm: float

    def holds(self, centre_mm: tuple[float, float], x_mm: float, y_mm: float) -> bool:
        """Return whether a position is within the bar or disc around a centre."""
        x, y = centre_mm
        away_mm = abs(x_mm - x) if self.bars else math.hypot(x_mm - x, y_mm - y)
        return away_mm <= self.width_mm / 2


Question = (
    NumberQuestion
    | YesNoQuestion
    | TextQuestion
    | ChoiceQuestion
    | WholeNumberQuestion
    | ComparisonQuestion
    | VisualAnalogueQuestion
    | PointingQuestion
)
