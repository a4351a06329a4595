"""Interleaved tracks whose answers can be taken back, because a trial was voided afterwards."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable

    from slipscale.experiments.protocols.adaptive.interleaved import Interleaved
    from slipscale.experiments.protocols.adaptive.track import Track


class Answered(NamedTuple):
    """An answer, and where it belongs."""

    track: int
    level: float
    correct: bool


class AnsweredTracks:
    """Tracks, and what was answered in which trial.

    A trial that is voided while it runs, or times out, gives no answer: its track and level come
    again. An answer that is taken back later is as if it had not been given: its track is worked
    out again from its other answers, at the levels at which these were.

    Parameters
    ----------
    start : Interleaved
        The tracks before their first trial.
    """

    def __init__(self, start: Interleaved) -> None:
        self._start = start
        self._answers: dict[int, Answered] = {}
        self.now = start

    def answer(self, trial: int, *, correct: bool) -> None:
        """Note the answer of a trial, at the level that is due."""
        self._answers[trial] = Answered(self.now.current, self.now.level, correct)
        self.now = self.now.answered(correct=correct)

    def take_back(self, trials: Iterable[int]) -> None:
        """Take the answers of some trials back; those that gave none change nothing."""
        gone = [self._answers.pop(trial) for trial in trials if trial in self._answers]
        if gone:
            again = tuple(answered.track for answered in gone)
            tracks = tuple(self._track(number) for number in range(len(self.now.tracks)))
            self.now = self.now.taken_back(tracks, again)

    def _track(self, number: int) -> Track:
        """Return a track worked out from its answers."""
        track = self._start.tracks[number]
        for answered in self._answers.values():
            if answered.track == number:
                track = track.answered(correct=answered.correct, at_level=answered.level)
        return track
