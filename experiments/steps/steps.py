"""Define the steps that a protocol yields, and list the replies that it receives.

A protocol is a plain generator: it yields a `Step`, and receives the reply listed in the table
below. A protocol cannot access the clock, the screen, the plate or files. Steps contain only plain
data, so that they can be recorded in the journal. Text shown to the participant never contains an
amplitude.

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

A trial may present several surfaces, each in an *interval*. The field ``interval`` of `Present`,
`Explore` and `Silence` is then the interval's number (1, 2, ...). An interrupted trial is repeated
from the first interval.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeVar

from slipscale.experiments.steps.replies import Answer
from slipscale.experiments.steps.rounding import rounded

if TYPE_CHECKING:
    from slipscale.experiments.steps.questions.base import Question
    from slipscale.experiments.steps.trial import Trial
    from slipscale.stimuli.headphone_sounds import HeadphoneSound
    from slipscale.stimuli.surface import Stimulus

Kind = TypeVar("Kind", bound="Question")


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """Sound played before a question, with the text that is shown during the sound."""

    sound: HeadphoneSound
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Instruct:
    """Text that the participant reads at their own pace. ``last`` marks the last text of a run."""

    text: str
    title: str = ""
    trial: Trial | None = None
    last: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Guide:
    """Instructions for stroking: speed, force and direction; a moving mark can show the speed.

    The speed or force is None if the study does not prescribe it. If ``passive`` is True, a stage
    makes the strokes.
    """

    speed_mm_s: float | None
    normal_force_n: float | None
    direction: Literal["any", "forward", "backward"]
    stroke_mm: float
    pacer: bool
    passive: bool = False

    def place_share(self, time_s: float) -> float | None:
        """Return the position of the mark on the stroke (0 to 1) at a time; None without a mark."""
        if not (self.pacer and self.speed_mm_s):
            return None
        strokes = time_s * self.speed_mm_s / self.stroke_mm
        if self.direction == "any":
            return 1 - abs(strokes % 2 - 1)
        return strokes % 1 if self.direction == "forward" else 1 - strokes % 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Explore:
    """Exploration of the surface until the participant continues, for at least ``minimum_s``.

    If ``maximum_s`` is set, a countdown is shown, and the step ends after this time. ``guide``
    contains instructions for stroking, if the study has any.
    """

    text: str
    trial: Trial | None = None
    minimum_s: float = 0.0
    maximum_s: float | None = None
    interval: int | None = None
    guide: Guide | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Present:
    """Present a surface on the plate.

    If participants judge a difference, ``lead_in`` is the surface that they explore before
    ``surface``. A lead-in that the plate is already producing is not presented again. ``second`` is
    the level of a second actuator, in the quantity of that actuator. The name ``second`` does not
    end in ``_level``, because this suffix is reserved for levels in the plate's quantity.
    """

    surface: Stimulus
    trial: Trial | None = None
    lead_in: tuple[Present, Explore] | None = None
    interval: int | None = None
    second: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ask:
    """Question to be asked; ``name`` is the data set column in which the answer is stored.

    If ``trial`` is None, the answer belongs to ``task``; if ``task`` is also empty, the question is
    about the participant. ``by`` specifies who enters the answer: the participant, or the operator,
    who types what the participant says or makes a decision. ``played`` is a sound that precedes the
    question; if no sound can be played, the reply is `NO_SOUND`. If ``back`` is True, the
    participant can return to the previous question with the reply `BACK`.
    """

    name: str
    question: Question
    trial: Trial | None = None
    task: str = ""
    time_limit_s: float | None = None
    by: Literal["participant", "operator"] = "participant"
    played: Played | None = None
    back: bool = False

    def of_kind(self, kind: type[Kind]) -> Kind:
        """Return the question, which must be of a certain kind."""
        if not isinstance(self.question, kind):
            raise TypeError(f"'{self.name}' is a {type(self.question).__name__}")
        return self.question


@dataclass(frozen=True, slots=True, kw_only=True)
class Silence:
    """Switch off the plate between surfaces or after an exploration."""

    trial: Trial | None = None
    interval: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjust:
    """Adjustment of the amplitude of the last surface by the participant.

    Parameters
    ----------
    name : str
        Name of the data set column that stores the final amplitude in µm peak to peak.
    text : str
        The instruction; it contains no amplitude.
    trial : Trial
    interval : int
        The interval in which the surface to be adjusted was presented.
    step_level : float
        The change in amplitude per notch of the wheel or per key press.
    lowest_level, highest_level : float
        The limits of the adjustment.
    time_limit_s : float or None
        Time limit, after which the step ends at the current amplitude and counts as timed out. The
        time spent on the reference is not counted.
    again : (Present, Explore) or None
        The reference, which the participant can request any number of times. After the reference,
        the adjusted surface is presented again at its current amplitude.
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
        """Return the amplitude after turning the wheel by ``notches``, clipped to the limits."""
        aim_level = rounded(from_level + notches * self.step_level)
        return min(max(aim_level, self.lowest_level), self.highest_level)

    def with_less_time(self, spent_s: float) -> Adjust:
        """Return a copy of the step whose time limit, if any, is reduced by ``spent_s``."""
        if self.time_limit_s is None:
            return self
        return replace(self, time_limit_s=max(self.time_limit_s - spent_s, 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Feedback:
    """Feedback such as "correct", shown for ``duration_s`` seconds."""

    text: str
    duration_s: float
    trial: Trial | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Rest:
    """Break of at least ``minimum_s`` seconds, after ``done`` of ``total`` trials."""

    text: str
    done: int
    total: int
    minimum_s: float = 0.0
    trial: Trial | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class EndTrial:
    """End of a trial. The reply lists the trials that the operator voids."""

    trial: Trial


@dataclass(frozen=True, slots=True, kw_only=True)
class EndBlock:
    """End of a block, at which the operator can still void its last trial.

    The reply lists the trials that the operator voids while the participant reads ``screen``. The
    protocol can repeat these trials before it continues.
    """

    screen: Instruct | Rest
    trial: Trial | None = None


ParticipantStep = Instruct | Explore | Ask | Rest | Feedback

Step = ParticipantStep | Present | Adjust | Silence | EndTrial | EndBlock

Steps = Generator[Step, Answer, None]
