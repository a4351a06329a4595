"""The vocabulary of a protocol: the steps that it yields, and the replies that it receives.

A protocol is a plain generator: it yields a `Step`, and receives the reply listed in the table
below. It has no access to the clock, screen, plate or files. Steps are recorded in the journal, so
each is plain data. Texts shown to the participant never contain an amplitude.

============  =====================================================  ==============
step          what the session does                                  reply
============  =====================================================  ==============
`Instruct`    shows a text until the participant continues           `Reply`
`Present`     presents a surface, settled and read back              `Presented`
`Explore`     lets the participant stroke the surface                `Reply`
`Ask`         asks a question                                        `Reply`
`Adjust`      lets the participant adjust the surface's amplitude    `Adjusted`
`Feedback`    shows a text for a fixed time                          `Reply`
`Silence`     stops the plate                                        None
`Rest`        shows a break screen with the progress                 `Reply`
`EndTrial`    closes a trial; the reply lists voided trials          `Voided`
`EndBlock`    shows the screen after a block; same reply             `Voided`
============  =====================================================  ==============

A trial may present several surfaces, each in an *interval*: `Present`, `Explore` and `Silence`
carry its number, 1, 2, ... If such a trial is interrupted, its script is rerun from the first
interval.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

from slipscale.experiments.protocols.adaptive.track import rounded

if TYPE_CHECKING:
    from slipscale.stimuli.headphone_sounds import HeadphoneSound
    from slipscale.stimuli.surface import Stimulus

Phase = Literal["practice", "main"]
#: What a comparison asks for; odd: the one that differs from the others.
Sought = Literal["most", "least", "odd"]
Value = str | float | bool | None
# Name of the question that asks for the participant's consent: "yes" or "no".
CONSENT = "informed_consent"
# Reply to a question about a sound that could not be played.
NO_SOUND = "no_sound"
# Participant's reply to an `Adjust` step to request the reference.
FEEL_AGAIN = "feel again"
# Participant's reply that returns to the previous question; it cannot occur in a text.
BACK = "\b"


def factor_level(value: Value) -> str:
    """Return a factor level as written in keys.

    >>> factor_level(50.0), factor_level("left")
    ('50', 'left')
    """
    return f"{value:g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """The trial that a step belongs to.

    Parameters
    ----------
    task : str
        The data set's task label, letters and digits only ("magnitudeestimation").
    number : int
        1, 2, ... in order of presentation within the task; a repeated trial gets a new number.
    total : int
        Expected number of trials in the task, including practice.
    phase : {"practice", "main"}
        Practice trials are recorded and not analysed.
    factors : Mapping
        The protocol's own columns of the data set ("block", "series", ...).
    repeats : int or None
        Number of the voided trial that this one repeats.
    """

    task: str
    number: int
    total: int
    phase: Phase = "main"
    factors: Mapping[str, Value] = field(default_factory=dict)
    repeats: int | None = None


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """A sound that is played before a question, and the text shown meanwhile."""

    sound: HeadphoneSound
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruct:
    """A text that the participant reads at their own pace. ``last`` marks the closing text."""

    text: str
    title: str = ""
    trial: Trial | None = None
    last: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Guide:
    """How to stroke a surface: speed, force and direction, and whether a mark shows the speed.

    Speed and force are None if any is accepted.
    """

    speed_mm_s: float | None
    normal_force_n: float | None
    direction: Literal["any", "forward", "backward"]
    stroke_mm: float
    pacer: bool

    def place_share(self, time_s: float) -> float | None:
        """Return a mark's position on the stroke, 0 to 1, at a time; None without speed."""
        if not (self.pacer and self.speed_mm_s):
            return None
        strokes = time_s * self.speed_mm_s / self.stroke_mm
        if self.direction == "any":
            return 1 - abs(strokes % 2 - 1)
        return strokes % 1 if self.direction == "forward" else 1 - strokes % 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Explore:
    """Exploration of the surface until the participant continues, for at least ``minimum_s``.

    If ``maximum_s`` is set, a countdown is shown, and the step then ends automatically. ``guide``
    states how to stroke, if the study does.
    """

    LATER: ClassVar[tuple[str, ...]] = ("guide",)
    text: str
    trial: Trial | None = None
    minimum_s: float = 0.0
    maximum_s: float | None = None
    interval: int | None = None
    guide: Guide | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Present:
    """Present a surface on the plate.

    ``lead_in`` is the surface to be felt first, with its exploration, if the question is about a
    difference. The session performs it unless the plate already presents that surface.
    """

    surface: Stimulus
    trial: Trial | None = None
    lead_in: tuple[Present, Explore] | None = None
    interval: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ask:
    """A question; ``name`` is the data set column for the answer.

    Outside a trial, ``task`` is the task to which the answer belongs; without a task, the question
    is about the participant. ``by`` defines who enters the answer; the operator types what the
    participant says, or makes a decision. ``played`` is a sound to play first; if no sound can be
    played, the reply is `NO_SOUND`. With ``back``, the participant can return to the previous
    question, and the reply is then `BACK`.
    """

    name: str
    question: Question
    trial: Trial | None = None
    task: str = ""
    time_limit_s: float | None = None
    by: Literal["participant", "operator"] = "participant"
    played: Played | None = None
    back: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence:
    """Stop the plate: between surfaces, or when exploration is over."""

    trial: Trial | None = None
    interval: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjust:
    """Adjustment of the last surface's amplitude, as instructed by ``text``.

    Parameters
    ----------
    name : str
        The data set column for the final amplitude, in µm peak to peak.
    text : str
        The instruction; it contains no amplitude.
    trial : Trial
    interval : int
        The interval in which the surface to be adjusted was presented.
    step_level : float
        The change per notch of the wheel or per key press.
    lowest_level, highest_level : float
        The limits of the adjustment.
    time_limit_s : float or None
        After this time the step ends at the current amplitude and counts as timed out. Time for
        repeating the reference does not count.
    again : (Present, Explore) or None
        The reference that can be repeated on request, any number of times. The adjusted surface
        then returns to its current amplitude.
    """

    name: str
    text: str
    trial: Trial
    interval: int
    step_level: float
    lowest_level: float
    highest_level: float
    time_limit_s: float | None = None
    again: tuple[Present, Explore] | None = None

    def turned_level(self, from_level: float, notches: int) -> float:
        """Return the amplitude after a number of notches, within the limits, µm peak to peak."""
        aim_level = rounded(from_level + notches * self.step_level)
        return min(max(aim_level, self.lowest_level), self.highest_level)

    def with_less_time(self, spent_s: float) -> Adjust:
        """Return the step with its time limit, if any, reduced by the elapsed time."""
        if self.time_limit_s is None:
            return self
        return replace(self, time_limit_s=max(self.time_limit_s - spent_s, 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Feedback:
    """A text that disappears after ``duration_s``, such as whether the answer was right."""

    text: str
    duration_s: float
    trial: Trial | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """A break of at least ``minimum_s``. ``done`` of ``total`` trials are over."""

    text: str
    done: int
    total: int
    minimum_s: float = 0.0
    trial: Trial | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class EndTrial:
    """A trial is complete."""

    trial: Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class EndBlock:
    """The last trial before a text or a break is complete, but may still be voided.

    The participant reads ``screen``. The reply contains the trials that the operator voids
    meanwhile, so that the protocol can repeat them before it continues.
    """

    screen: Instruct | Rest
    trial: Trial | None = None


ParticipantStep = Instruct | Explore | Ask | Rest | Feedback
Step = ParticipantStep | Present | Adjust | Silence | EndTrial | EndBlock


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply:
    """What a participant did.

    Parameters
    ----------
    value : str, float, bool or None
        The answer; None if there was no question or the time ran out.
    onset_s : float
        When the screen was shown, on the session's clock.
    response_time_s : float or None
        Time from screen onset to the key press that completed the answer; None if the time ran
        out.
    time_source : str
        Source of the time: "ptb" (the key event's own time stamp), "window" (when the window
        received it), "operator" (when the operator submitted the answer), "simulated", "scripted".
    timed_out : bool
        Whether the time limit ran out first.
    rejected : tuple of str
        Entries that were rejected, verbatim and in order.
    """

    value: Value = None
    onset_s: float = 0.0
    response_time_s: float | None = None
    time_source: str = "scripted"
    timed_out: bool = False
    rejected: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjusted(Reply):
    """The result of an adjustment; the value is the final amplitude, µm peak to peak.

    Parameters
    ----------
    readback_level : float or None
        The plate's readback at the end.
    trace : tuple of pairs
        Each intermediate amplitude, and when it settled: (seconds from the beginning, µm peak
        to peak); the first pair is the start.
    again_s : tuple of float
        When the reference was requested, in seconds from the beginning.
    """

    readback_level: float | None = None
    trace: tuple[tuple[float, float], ...] = ()
    again_s: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Presented:
    """What the plate did; commanded and readback levels are stored separately.

    For a texture, both are the mean, at which the plate settles before it plays. ``readback_kind``
    describes the reliability of the readback (see `slipscale.hardware.records.Readback`). Plate
    voltage and temperature are None if unknown.
    """

    commanded_level: float
    readback_level: float | None
    readback_kind: str
    settled_by: str
    onset_s: float
    voltage_v_peak: float | None = None
    temperature_c: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Voided:
    """The numbers of the trials voided since the last `Voided`; the protocol repeats them."""

    trials: tuple[int, ...] = ()


Answer = Reply | Presented | Voided | None
Steps = Generator[Step, Answer, None]
