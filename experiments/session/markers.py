"""Markers: what happens in a session, told at once to recorders outside it (EEG, video, ...).

A marker says what happened and in which trial, never how strong the vibration was: whoever
watches the recorder must not learn it. The data set's rows join the amplitudes by trial.
"""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from slipscale.experiments.protocols.steps import Step


class Event(IntEnum):
    """What is marked, with the code that a trigger line carries.

    The codes are powers of two, so that a line with eight wires shows each on a wire of its own.
    """

    BEGIN = 1  # the run begins or is taken up again
    ONSET = 2  # the plate is told to change to a surface
    SETTLED = 4  # the surface has settled and can be felt
    ANSWER = 8  # a question was answered
    FAULT = 16  # the rig failed: the trial's surface was lost
    PAUSE = 32  # the operator interrupted the session
    END = 64  # the run is over, or stopped


class MarkerOutput(Protocol):
    """One way out of the computer."""

    name: str

    def send(self, event: Event, trial: int | None) -> None:
        """Send at once; OSError where the device does not take it."""

    def close(self) -> None:
        """Leave the device with no line active."""


class Markers:
    """All outputs of a session.

    A recorder that fails must not end a session: it is told, written down and left out.

    Parameters
    ----------
    outputs : sequence of MarkerOutput
        Open.
    lost : callable
        Told the output's name and the reason when one fails.
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
        """The outputs that still work."""
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
