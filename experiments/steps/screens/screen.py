"""Base class for screens, which are independent of any window or clock.

A screen receives inputs and the time since the screen appeared. The screen returns the contents to
draw and, when the screen ends, a `Reply` without times. The time is always passed as an argument,
so tests of screens do not have to wait.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from slipscale.experiments.languages.texts import Texts
from slipscale.experiments.steps.replies import Reply
from slipscale.experiments.steps.screens.scene import Scene


class Screen(ABC):
    """Base class for screens; inputs without a method of their own have no effect.

    Parameters
    ----------
    texts : Mapping
        The texts in the participant's language.
    time_limit_s : float or None
        Time after which the screen ends with a time-out.

    Attributes
    ----------
    single_key : bool
        Whether a single key press ends the screen, so that the participant must first release keys
        held since the previous screen.
    pointed : bool
        Whether the screen is operated with the mouse, so that the pointer is visible.
    rejected : list of str
        Rejected entries, verbatim and in order.
    """

    single_key: bool = True
    pointed: bool = False

    def __init__(self, texts: Texts, time_limit_s: float | None = None) -> None:
        self.rejected: list[str] = []
        self.texts = texts
        self.limit_s = time_limit_s

    @abstractmethod
    def scene(self, elapsed_s: float) -> Scene:
        """Return the contents of the screen ``elapsed_s`` after it appeared."""

    @abstractmethod
    def press(self, character: str, elapsed_s: float) -> Reply | None:
        """Process a character; return the outcome if the character ended the screen."""

    def erase(self) -> Reply | None:
        """Delete the last character; return the outcome if this closes the screen."""
        return None

    def move(self, notches: int) -> None:  # noqa: B027 - optional
        """Move the mark to the right by a number of notches."""

    def turn(self, notches: int) -> None:
        """Move the mark or the selection up. On a screen with one direction, up is right."""
        self.move(notches)

    def point(  # the pointer has no effect
        self, _x: float, _y: float, _elapsed_s: float, *, dragged: bool
    ) -> Reply | None:
        """Process a click or touch. Return the outcome if the click or touch ended the screen."""
        del dragged
        return None

    def see(self, _x_mm: float, _y_mm: float) -> None:  # noqa: B027 - optional
        """Process the finger's measured position."""

    @property
    def typed(self) -> str:
        """The entry that has been made but not submitted."""
        return ""

    def offer(self, typed: str) -> None:  # noqa: B027 - optional
        """Restore the entry that the participant made before an interruption."""

    def expire(self, elapsed_s: float) -> Reply | None:
        """Return the screen's result if its time limit has passed."""
        over = self.limit_s is not None and elapsed_s >= self.limit_s
        return Reply(timed_out=True) if over else None
