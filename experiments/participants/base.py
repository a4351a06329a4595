"""Common interface for participants, and exceptions that end a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol, Self

if TYPE_CHECKING:
    from slipscale.experiments.steps.replies import Reply
    from slipscale.experiments.steps.steps import Adjust, ParticipantStep
    from slipscale.hardware.contact.source import Finger

# A function that is called on every frame while a participant reads, explores or answers. The
# function checks the plate and the operator's commands, and may raise an exception (for a plate
# fault, a pause or a stop).
# Participant classes must let the exception propagate, and must be able to start the same step
# again afterwards.
Watch = Callable[[], None]

# Increases or decreases the surface's level by a number of notches. Its exceptions must also
# propagate.
Turn = Callable[[int], None]

Kind = Literal["person", "simulated", "scripted"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Unfinished:
    """An entry that was interrupted before it was submitted.

    Parameters
    ----------
    entry : str
        The contents of the answer field.
    rejected : tuple of str
        Entries for the same question that were rejected before the interruption.
    """

    entry: str = ""
    rejected: tuple[str, ...] = ()


class StopRequested(Exception):
    """The participant pressed Escape and confirmed, or the operator stopped the session."""


class Participant(Protocol):
    """Common interface for real, simulated and scripted participants.

    A participant is a context manager that opens and closes the window.
    """

    kind: ClassVar[Kind]
    # The initial contents of the next answer field. If `perform` raises an exception, the contents
    # at that time are stored here.
    unfinished: Unfinished
    # The finger's measured position, for screens that show it; set by the session.
    cursor_mm: tuple[float, float] | None

    @property
    def finger(self) -> Finger | None:
        """The source of the finger's position, if any: the window pointer or a simulated finger."""

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Carry out one step and return what the participant did.

        Parameters
        ----------
        step : Instruct, Explore, Ask, Rest or Feedback
            The step to carry out, which never contains an amplitude.
        watch : callable
            Function to call on every frame. Its exceptions must be propagated.

        Raises
        ------
        StopRequested
            If the participant requested to stop and confirmed the request.
        """

    def adjust(self, step: Adjust, turn: Turn, watch: Watch, *, again: int = 0) -> Reply:
        """Let the participant adjust the surface as the step instructs (see also `perform`).

        If the participant requests the reference, the reply's value is `FEEL_AGAIN`. The session
        then presents the reference and calls this method again; ``again`` counts these repetitions.
        """

    def hold(self, text: str, until: Callable[[], bool]) -> None:
        """Show ``text`` during a pause or a repair of the rig, until ``until()`` returns True."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_error: object) -> None: ...
