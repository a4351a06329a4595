"""Who answers, behind one small interface, and the ways out of a step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol, Self

if TYPE_CHECKING:
    from types import TracebackType

    from slipscale.experiments.protocols.steps import Adjust, ParticipantStep, Reply
    from slipscale.hardware.contact.source import Finger

# Called at every frame while a participant reads, explores or answers. It checks the plate and
# the operator and may raise (a plate fault, a pause, a stop): a participant class lets
# the exception pass and must be able to start the same step again afterwards.
Watch = Callable[[], None]

# Turns the surface by so many notches, up or down; what it raises passes through as well.
Turn = Callable[[int], None]

Kind = Literal["person", "simulated", "scripted"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Unfinished:
    """What was typed of an answer when something interrupted it.

    Parameters
    ----------
    entry : str
        What stood in the place for the answer.
    rejected : tuple of str
        Entries before it that were not an answer.
    """

    entry: str = ""
    rejected: tuple[str, ...] = ()


class StopRequested(Exception):
    """The participant pressed Escape and confirmed, or the operator stopped the session."""


class Participant(Protocol):
    """A person at a screen, or a stand-in. A context manager: entering opens the window."""

    kind: ClassVar[Kind]
    # Set before a question is asked: what to offer as typed already. Where `perform` raises, it
    # says what was typed by then.
    unfinished: Unfinished

    @property
    def finger(self) -> Finger | None:
        """Who can tell where the finger is: a window by its pointer, a simulated one by itself."""

    def perform(self, step: ParticipantStep, watch: Watch) -> Reply:
        """Carry out one step and return what the participant did.

        Parameters
        ----------
        step : Instruct, Explore, Ask, Rest or Feedback
            It never holds an amplitude.
        watch : callable
            To be called at every frame; what it raises passes through.

        Raises
        ------
        StopRequested
            The participant asked to stop, and confirmed.
        """

    def adjust(self, step: Adjust, turn: Turn, watch: Watch, *, again: int = 0) -> Reply:
        """Have the participant turn the surface until it is as asked for; see `perform`.

        The reply's value is `FEEL_AGAIN` where the participant asks for the reference; this is
        then called once more, and ``again`` is how often they felt it again.
        """

    def hold(self, text: str, until: Callable[[], bool]) -> None:
        """Show ``text`` (the operator paused, or the rig is being repaired) until ``until()``."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...
