"""The replies that a protocol receives to its steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from slipscale.experiments.steps.trial import Value  # noqa: TC001 - pydantic resolves it

# Reply to a question about a sound that could not be played.
NO_SOUND = "no_sound"
# Participant's reply to an `Adjust` step to request the reference.
FEEL_AGAIN = "feel again"
# Participant's reply that returns to the previous question; it cannot occur in a text.
BACK = "\b"


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
    voltage, temperature and the readback of a second actuator are None if unknown.
    """

    LATER: ClassVar = frozenset({"second_readback"})
    commanded_level: float
    readback_level: float | None
    readback_kind: str
    settled_by: str
    onset_s: float
    voltage_v_peak: float | None = None
    temperature_c: float | None = None
    second_readback: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Voided:
    """The numbers of the trials voided since the last `Voided`.

    The protocol repeats ``trials``. It does not repeat ``dropped`` ones, and ignores their answers.
    """

    LATER: ClassVar = frozenset({"dropped"})
    trials: tuple[int, ...] = ()
    dropped: tuple[int, ...] = ()


Answer = Reply | Presented | Voided | None
