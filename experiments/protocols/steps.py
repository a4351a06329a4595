"""The vocabulary of a protocol: the steps it yields, and the replies it is sent.

A protocol is a plain generator: it yields one of `Step` and receives the reply that the table
`REPLIES` names for it. It knows no clock, screen, plate or file. Steps are what the journal
records, so each is plain data; what a participant is shown never holds an amplitude.

============  =====================================================  ==============
step          what the session does                                  reply
============  =====================================================  ==============
`Instruct`    shows a text until the participant goes on             `Reply`
`Present`     makes a surface on the plate, settled and read back    `Presented`
`Explore`     lets the participant stroke the surface                `Reply`
`Ask`         asks a question                                        `Reply`
`Adjust`      has the participant turn the surface's amplitude       `Adjusted`
`Feedback`    shows a text for a fixed time                          `Reply`
`Silence`     stops the plate                                        None
`Rest`        shows a break screen with the progress                 `Reply`
`EndTrial`    closes a trial; is told which trials were voided       `Voided`
`EndBlock`    shows the screen after a block; is told likewise       `Voided`
============  =====================================================  ==============

A trial may present several surfaces, each in an *interval*: `Present`, `Explore` and `Silence`
carry its number, 1, 2, ... Whatever interrupts such a trial, its script is performed again from
the first interval before it goes on.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from slipscale.experiments.protocols.adaptive.track import rounded

if TYPE_CHECKING:
    from slipscale.stimuli.headphone_sounds import HeadphoneSound
    from slipscale.stimuli.surface import Surface

Phase = Literal["practice", "main"]
Value = str | float | bool | None
# The name of the question whether the participant agrees to take part: "yes" or "no".
CONSENT = "informed_consent"
# The reply to a question about a sound that could not be played.
NO_SOUND = "no_sound"
# What a participant's class replies to an `Adjust` where the reference is to be felt again.
FEEL_AGAIN = "feel again"


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """Which trial a step belongs to.

    Parameters
    ----------
    task : str
        The data set's task label, letters and digits only ("magnitudeestimation").
    number : int
        1, 2, ... in the order of presentation within the task; a repeated trial has its own.
    total : int
        How many trials the task is expected to have, practice included.
    phase : {"practice", "main"}
        Practice trials are recorded and not analysed.
    factors : Mapping
        The protocol's own columns of the data set ("block", "series", ...).
    repeats : int or None
        The number of the voided trial that this one repeats.
    """

    task: str
    number: int
    total: int
    phase: Phase = "main"
    factors: Mapping[str, Value] = field(default_factory=dict)
    repeats: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberQuestion:
    """Any number of 0 or more, decimals allowed, on a scale of the participant's own.

    ``positive`` bars 0 as well (the top of a scale cannot be 0).
    """

    prompt: str
    positive: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoQuestion:
    """Yes or no; the reply's value is a bool."""

    prompt: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TextQuestion:
    """Free text, kept word for word."""

    prompt: str
    max_length: int = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceQuestion:
    """One of a few; ``options`` are (code for the data, words on the screen)."""

    prompt: str
    options: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WholeNumberQuestion:
    """A whole number from ``minimum`` to ``maximum``, both included: an age in years."""

    prompt: str
    minimum: int
    maximum: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonQuestion:
    """Which of the surfaces that were presented; the reply's value is its number, 1, 2, ...

    ``options`` are the words on the screen, in the order of presentation ("the first", ...);
    ``seeks`` says which is asked for: the most slippery, or the least.
    """

    prompt: str
    options: tuple[str, ...]
    seeks: Literal["most", "least"] = "most"


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualAnalogueQuestion:
    """A mark on a line between two words; the reply's value is its place, 0 (left) to 100 (right).

    Parameters
    ----------
    prompt : str
        The question.
    left, right : str
        The words at the line's ends.
    resolution, key_step : float
        Distance of two places that the mark can have, and what one press of an arrow key moves it.
    start : float
        Where keys move the mark from.
    start_shown : bool
        Whether the mark stands there before the first press or click.
    """

    prompt: str
    left: str
    right: str
    resolution: float
    key_step: float
    start: float
    start_shown: bool

    def nearest(self, place: float) -> float:
        """Return the nearest place that the mark can have; beyond the line it is its end."""
        held = min(max(place, 0.0), 100.0)
        # Rounded: three tenths are 0.3, and not a float beside it.
        return round(round(held / self.resolution) * self.resolution, 6)


Question = (
    NumberQuestion
    | YesNoQuestion
    | TextQuestion
    | ChoiceQuestion
    | WholeNumberQuestion
    | ComparisonQuestion
    | VisualAnalogueQuestion
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """A sound that is heard before a question, and what is read meanwhile."""

    sound: HeadphoneSound
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruct:
    """A text, read at the participant's own pace. ``last`` marks the thank-you."""

    text: str
    title: str = ""
    trial: Trial | None = None
    last: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Explore:
    """Stroke the surface; ends when the participant goes on, at the earliest after ``minimum_s``.

    With ``maximum_s`` a countdown is shown and the step ends by itself.
    """

    text: str
    trial: Trial | None = None
    minimum_s: float = 0.0
    maximum_s: float | None = None
    interval: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Present:
    """Make a surface.

    ``lead_in`` is what must be felt first (a surface and its exploration): where a difference is
    asked for, the session performs it unless the plate presents just that surface.
    """

    surface: Surface
    trial: Trial | None = None
    lead_in: tuple[Present, Explore] | None = None
    interval: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Ask:
    """A question; ``name`` is the data set's column for the answer.

    Outside a trial, ``task`` says of which task's run the answer is a part; without a task it is
    about the participant. ``by`` says who enters the answer: the operator types what the
    participant says, or decides. What is ``played`` is heard first; where there is nothing to hear
    it with, the reply is `NO_SOUND`.
    """

    name: str
    question: Question
    trial: Trial | None = None
    task: str = ""
    time_limit_s: float | None = None
    by: Literal["participant", "operator"] = "participant"
    played: Played | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence:
    """Stop the plate: between surfaces, or when exploration is over."""

    trial: Trial | None = None
    interval: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjust:
    """Turn the amplitude of the surface that was presented last until it is as asked for.

    Parameters
    ----------
    name : str
        The data set's column for the amplitude reached, µm peak to peak.
    text : str
        What to turn for; it holds no amplitude.
    trial : Trial
    interval : int
        The interval in which the surface to be turned was presented.
    step_level : float
        What one notch of the wheel, or one press of a key, changes.
    lowest_level, highest_level : float
        It cannot be turned beyond these.
    time_limit_s : float or None
        Then it is over as it stands, and counts as timed out. Feeling again does not count.
    again : (Present, Explore) or None
        What can be felt again on request, as often as wanted; the surface is then as it had been
        turned to.
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
        """Return where so many notches lead, held within the bounds, µm peak to peak."""
        aim_level = rounded(from_level + notches * self.step_level)
        return min(max(aim_level, self.lowest_level), self.highest_level)

    def with_less_time(self, spent_s: float) -> Adjust:
        """Return the step with so much of its time limit gone, where it has one."""
        if self.time_limit_s is None:
            return self
        return replace(self, time_limit_s=max(self.time_limit_s - spent_s, 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Feedback:
    """A text that goes by itself after ``duration_s``: whether the answer was right."""

    text: str
    duration_s: float
    trial: Trial | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """A break. ``done`` of ``total`` trials are over; it lasts at least ``minimum_s``."""

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
    """The last trial before a text or a break is over, and may still be voided.

    The participant reads ``screen``; what the operator voids meanwhile is in the reply, so that
    the protocol can repeat it before it goes on.
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
        The answer; None where nothing was asked or the time ran out.
    onset_s : float
        When the screen was shown, on the session's clock.
    response_time_s : float or None
        From the screen to the key that completed the answer; None where the time ran out.
    time_source : str
        Where the time was taken: "ptb" (the key event's own time stamp), "window" (when the
        window was told of it), "operator" (when the operator handed the answer in), "simulated",
        "scripted".
    timed_out : bool
        The time limit ran out first.
    rejected : tuple of str
        Entries that were not an answer, word for word, in order.
    """

    value: Value = None
    onset_s: float = 0.0
    response_time_s: float | None = None
    time_source: str = "scripted"
    timed_out: bool = False
    rejected: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjusted(Reply):
    """What a participant turned the plate to: the value is that amplitude, µm peak to peak.

    Parameters
    ----------
    readback_level : float or None
        What the plate says it makes, at the end.
    trace : tuple of pairs
        Each amplitude on the way, and when it had settled: (seconds from the beginning, µm peak
        to peak); the first is where it began.
    again_s : tuple of float
        When the reference was asked for again, likewise.
    """

    readback_level: float | None = None
    trace: tuple[tuple[float, float], ...] = ()
    again_s: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Presented:
    """What the plate did: commanded and read back are kept apart.

    Of a texture both are the mean, where the plate settles before it plays.
    ``readback_kind`` says how far the readback can be trusted (see
    `slipscale.hardware.records.Readback`). Voltage at the plate and temperature are None where they
    are not known.
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
    """The numbers of the trials voided since this was last told: the protocol repeats them."""

    trials: tuple[int, ...] = ()


Answer = Reply | Presented | Voided | None
Steps = Generator[Step, Answer, None]
