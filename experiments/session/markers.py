"""Markers: report session events to external recorders (EEG, video, ...) without delay.

A marker contains the event and the trial, but never the amplitude, because the person at the
recorder must stay blinded. To add the amplitudes later, join the markers with the rows of the data
set on the trial number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Protocol

from slipscale.experiments.steps.steps import Step


class Event(IntEnum):
    """Events that are sent as markers, and their trigger codes.

    The codes are powers of two, so that each event has its own line on an eight-line port.
    """

    BEGIN = 1  # the run begins or resumes
    ONSET = 2  # the plate is commanded to present a surface
    SETTLED = 4  # the surface has settled and can be felt
    ANSWER = 8  # a question was answered
    FAULT = 16  # the rig failed: the trial's surface was lost
    PAUSE = 32  # the operator interrupted the session
    END = 64  # the run is complete or was stopped


class MarkerOutput(Protocol):
    """Common interface for marker outputs."""

    name: str

    def send(self, event: Event, trial: int | None) -> None:
        """Send an event without delay. Raises OSError if the device rejects the event."""

    def close(self) -> None:
        """Set all signal lines to inactive, and close the output."""


class Markers:
    """All marker outputs of a session.

    If an output fails, the failure is reported and recorded, and the session continues without that
    output.

    Parameters
    ----------
    outputs : sequence of MarkerOutput
        The opened outputs.
    lost : callable
        Called when an output fails, with the output's name and the reason.
    """

    def __init__(
        self,
        outputs: Sequence[MarkerOutput] = (),
        lost: Callable[[str, str], None] = lambda _name, _reason: None,
    ) -> None:
        self._outputs = list(outputs)
        self.lost = lost

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the marker outputs that still work."""
        return tuple(output.name for output in self._outputs)

    def mark(self, event: Event, step: Step | None = None) -> None:
        """Send an event to every output."""
        trial = step.trial.number if step is not None and step.trial else None
        for output in list(self._outputs):
            try:
                output.send(event, trial)
            except OSError as error:
                self._outputs.remove(output)
                output.close()
                self.lost(output.name, str(error))
