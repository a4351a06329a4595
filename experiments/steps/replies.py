"""Replies to steps: the results that a protocol receives after each step that it yields."""

from __future__ import annotations

import math
from dataclasses import dataclass

from slipscale.experiments.steps.trial import Value

# Reply to a question whose sound could not be played.
NO_SOUND = "no_sound"
# Reply with which a participant requests the reference during an `Adjust` step.
FEEL_AGAIN = "feel again"
# Participant's reply that returns to the previous question; free text cannot contain this value.
BACK = "\b"


def is_answer(value: object) -> bool:
    """Return whether a value can be an answer: a text, a finite number, or true or false."""
    return isinstance(value, str | int) or (isinstance(value, float) and math.isfinite(value))


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply:
    """A participant's reply to a step.

    Parameters
    ----------
    value : str, float, bool or None
        The answer; None if there was no question or the time limit was reached.
    onset_s : float
        The time at which the screen appeared, on the session's clock.
    response_time_s : float or None
        Time from the onset of the screen to the key press that completed the answer; None if the
        time limit was reached.
    time_source : str
        Source of the time: "ptb" (the device's time stamp), "window" (receipt of the key by the
        window), "operator" (submission by the operator), "simulated" or "scripted".
    timed_out : bool
        Whether the time limit was reached.
    rejected : tuple of str
        Rejected entries, verbatim and in order.
    """

    value: Value = None
    onset_s: float = 0.0
    response_time_s: float | None = None
    time_source: str = "scripted"
    timed_out: bool = False
    rejected: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Adjusted(Reply):
    """Result of an adjustment, whose value is the final amplitude in µm peak to peak.

    Parameters
    ----------
    readback_level : float or None
        Amplitude read back from the plate at the end of the adjustment.
    trace : tuple of pairs
        The time at which each amplitude settled, in seconds from the beginning of the adjustment,
        and the amplitude in µm peak to peak. The first pair is the initial amplitude at 0 s.
    again_s : tuple of float
        The times at which the reference was requested, in seconds from the beginning of the
        adjustment.
    """

    readback_level: float | None = None
    trace: tuple[tuple[float, float], ...] = ()
    again_s: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Presented:
    """Result of a presentation, including the commanded and the measured level.

    For a texture, both levels describe the mean, at which the plate settles before the texture
    plays. ``readback_kind`` describes the reliability of the readback (see
    `slipscale.hardware.records.Readback`). Plate voltage, temperature and a second actuator's
    readback are None if unknown.
    """

    commanded_level: float
    readback_level: float | None
    readback_kind: str
    settled_by: str
    onset_s: float
    drive_voltage_v_peak: float | None = None
    temperature_c: float | None = None
    second_readback: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Voided:
    """The numbers of the trials that were voided since the last `Voided`.

    The protocol repeats ``trials``. Trials in ``dropped`` are not repeated, and their answers are
    ignored.
    """

    trials: tuple[int, ...] = ()
    dropped: tuple[int, ...] = ()


Answer = Reply | Presented | Voided | None
