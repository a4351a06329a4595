"""Interleave several tracks in one block, so that participants cannot infer the next level."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, Self

from slipscale.experiments.protocol_parts.adaptive.stopping import Stopping
from slipscale.experiments.protocol_parts.adaptive.track import Track
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.faults import UserError

Order = Literal["alternating", "shuffled"]


@dataclass(frozen=True, kw_only=True)
class Interleaved:
    """Interleaved tracks, which take turns until all have ended.

    In each round, every unfinished track has one trial.

    Parameters
    ----------
    tracks : tuple of Track
        The current state of each track.
    stopping : Stopping
        Rule that decides when a track ends.
    stream : callable
        Returns the random number stream for a round number. Calls with the same number must return
        the same stream.
    order : {"alternating", "shuffled"}
        Whether the tracks keep a fixed order or are shuffled in each round.
    left : tuple of int
        Indices of the tracks that still have a trial in the current round, in order of
        presentation.
    round_number : int
        Index of the current round: 0, 1, ...

    Raises
    ------
    UserError
        If there are no tracks, or the stopping rule is incompatible with a track.
    """

    tracks: tuple[Track, ...]
    stopping: Stopping
    stream: Callable[[int], Stream]
    order: Order = "shuffled"
    left: tuple[int, ...] = ()
    round_number: int = 0

    @classmethod
    def start(
        cls,
        tracks: tuple[Track, ...],
        stopping: Stopping,
        stream: Callable[[int], Stream],
        order: Order = "shuffled",
    ) -> Self:
        """Check the stopping rule for each track, and begin the first round."""
        if not tracks:
            raise UserError("interleaved tracks: expected at least one track")
        for track in tracks:
            stopping.check(track)
        before = cls(tracks=tracks, stopping=stopping, stream=stream, order=order)
        return replace(before, left=_round(before))

    @property
    def over(self) -> bool:
        """Whether all tracks have ended."""
        return not self.left

    @property
    def current(self) -> int:
        """Index of the track with the next trial. Raises IndexError if all tracks have ended."""
        return self.left[0]

    @property
    def level(self) -> float:
        """Level of the next trial (µm peak to peak). Raises IndexError if all tracks have ended."""
        return self.tracks[self.current].level

    @property
    def trials(self) -> int:
        """Number of answers so far in all tracks."""
        return sum(track.progress.trials for track in self.tracks)

    @property
    def most_trials(self) -> int:
        """Largest possible number of trials in all tracks."""
        return len(self.tracks) * self.stopping.most_trials

    @property
    def left_at_most(self) -> int:
        """Largest possible number of remaining trials."""
        most = self.stopping.most_trials
        return sum(most - track.progress.trials for track in self.tracks if self._goes_on(track))

    def taken_back(self, tracks: tuple[Track, ...], again: tuple[int, ...]) -> Self:
        """Return the interleaved tracks after some answers have been removed.

        ``tracks`` contains the tracks without the removed answers. ``again`` contains the track
        number of each removed answer. Each removed answer adds a trial to its track in the current
        round, unless the track has ended.
        """
        going = tuple(number for number in again if self._goes_on(tracks[number]))
        return replace(self, tracks=tracks, left=(*self.left, *going))

    def _goes_on(self, track: Track) -> bool:
        return self.stopping.reason(track.progress) is None

    def answered(self, *, correct: bool) -> Self:
        """Return the tracks, updated with an answer at the current level."""
        tracks = list(self.tracks)
        tracks[self.current] = tracks[self.current].answered(correct=correct)
        after = replace(self, tracks=tuple(tracks), left=self.left[1:])
        if after.left:
            return after
        after = replace(after, round_number=self.round_number + 1)
        return replace(after, left=_round(after))


def _round(block: Interleaved) -> tuple[int, ...]:
    """Return the order of the unfinished tracks in the current round."""
    going = [
        number
        for number, track in enumerate(block.tracks)
        if block._goes_on(track)  # noqa: SLF001 - its own module
    ]
    if block.order == "shuffled":
        going = block.stream(block.round_number).shuffled(going)
    return tuple(going)
