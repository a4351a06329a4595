"""Properties of a simulated participant on which simulated answers can depend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

T = TypeVar("T")


class Draws(Protocol):
    """Random numbers for a simulated participant's answers."""

    def below(self, bound: int, /) -> int:
        """Return a random integer, uniform on 0 ... bound - 1."""

    def uniform(self) -> float:
        """Return a random float, uniform on the open interval (0, 1)."""

    def normal(self) -> float:
        """Return a standard normal deviate."""

    def choice(self, items: Sequence[T], /) -> T:
        """Return a random item; all items are equally likely."""


class SimulatedPerson(Protocol):
    """Properties of a simulated participant that can influence simulated answers.

    All values depend on the seed, the participant, the trial and the plate's behaviour, never on
    the number of calls.
    """

    @property
    def language(self) -> str:
        """The language of verbal reports."""

    @property
    def scale_top(self) -> float:
        """The number that the person would give to the most slippery surface imaginable."""

    @property
    def rises(self) -> bool:
        """Whether the judged attribute increases with the level."""

    @property
    def pace(self) -> float:
        """The time that this person takes for an action, relative to the median person."""

    @property
    def turned(self) -> int:
        """Net number of notches turned so far in an `Adjust` step."""

    @property
    def felt_again(self) -> int:
        """Number of times that the reference was repeated in an `Adjust` step."""

    @property
    def felt_level(self) -> tuple[float, ...]:
        """The levels felt in this trial, µm peak to peak, in the order of its intervals."""

    @property
    def impressions(self) -> tuple[float, ...]:
        """Sensation strengths (0 to 100) in this trial, plus noise."""

    def usual(self, level: float) -> float:
        """Return the strength of sensation (0 to 100) that the person expects at a level."""

    def pick(self, strengths: Sequence[float]) -> int:
        """Return the index of the strength that the person judges largest.

        The choice also depends on lapses and on a bias towards one of the intervals.
        """

    def says_yes(self, strength: float) -> bool:
        """Return whether a difference between impressions is large enough for the answer "yes"."""

    def estimate(self) -> float:
        """Return a magnitude estimate of the last surface, on this person's own scale."""

    def rating(self, start: float) -> float:
        """Return a rating of the last surface on a line from 0 to 100.

        ``start`` is the initial position of the mark, towards which some people's ratings are
        biased.
        """

    def ratio(self) -> float:
        """Return the strength of the last surface relative to the standard, above 0."""

    def reaches(self, ratio: float) -> bool:
        """Return whether the last surface is at least ``ratio`` times as strong as the standard."""

    def lapses(self) -> bool:
        """Return whether this person answers this question at random (a lapse)."""

    def notices(self) -> bool:
        """Return whether the person perceives a difference between the last two surfaces."""

    def verbal_report(self) -> str:
        """Return the person's verbal report of what disappeared when the level decreased."""

    def stream(self, *purpose: str | int) -> Draws:
        """Return the random number stream of this person and trial for a purpose."""
