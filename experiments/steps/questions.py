"""Types of questions that a protocol can ask, with the values of their replies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple

from slipscale.experiments.steps.trial import Value

#: Which surface a comparison asks for; "odd" is the surface that differs from the others.
Sought = Literal["most", "least", "odd"]
# Name of the question about the participant's consent, whose answer is "yes" or "no".
CONSENT = "informed_consent"


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberQuestion:
    """Question answered with a number (0 or more, decimals allowed) on the participant's own scale.

    ``positive`` also excludes 0, for example for the top of a scale.
    """

    prompt: str
    positive: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoQuestion:
    """A yes/no question; the reply's value is a bool.

    For a comparison of surfaces, ``seeks`` specifies whether "yes" means more or less slippery.
    """

    #: Fields omitted from a record if they have their default value.
    LATER: ClassVar[tuple[str, ...]] = ("seeks",)
    prompt: str
    seeks: Sought = "most"


@dataclass(frozen=True, slots=True, kw_only=True)
class TextQuestion:
    """A question with a free-text answer. The answer is stored verbatim."""

    prompt: str
    max_length: int = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceQuestion:
    """Choice from ``options``, each of which is a pair of a code (for the data) and a label."""

    prompt: str
    options: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeNumberQuestion:
    """Question answered with a whole number from ``minimum`` to ``maximum``, such as an age."""

    prompt: str
    minimum: int
    maximum: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonQuestion:
    """Question answered by choosing one of several surfaces; the reply's value is its number.

    ``options`` contains the labels on the screen, in the order of presentation ("the first", ...).
    ``seeks`` specifies whether the question asks for the most slippery, the least slippery or the
    odd surface.
    """

    prompt: str
    options: tuple[str, ...]
    seeks: Sought = "most"


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualAnalogueQuestion:
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

    prompt: str
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
class PointingQuestion:
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

    prompt: str
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
