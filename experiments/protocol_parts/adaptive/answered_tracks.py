"""Interleaved tracks whose answers can be taken back if a trial is voided later."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
from slipscale.experiments.protocol_parts.adaptive.track import Track


class Answered(NamedTuple):
    """An answer, with its track and level."""

    track: int
    level: float
    correct: bool


class AnsweredTracks:
    """Interleaved tracks, together with the answers, keyed by trial.

    A trial that times out or is voided while it runs has no answer, so its track repeats the level.
    If an answer is taken back later, the track is recomputed from its remaining answers at their
    original levels.

    Parameters
    ----------
    start : Interleaved
        Interleaved tracks in their initial state, before the first trial.
    """

    def __init__(self, start: Interleaved) -> None:
        self._start = start
        self._answers: dict[int, Answered] = {}
        self.now = start

    def answer(self, trial: int, *, correct: bool) -> None:
        """Store the answer to a trial at the current level."""
        self._answers[trial] = Answered(self.now.current, self.now.level, correct)
        self.now = self.now.answered(correct=correct)

    def take_back(self, trials: Iterable[int]) -> None:
        """Remove the answers to the given trials, ignoring trials without an answer."""
        removed = [self._answers.pop(trial) for trial in trials if trial in self._answers]
        if removed:
            again = tuple(answered.track for answered in removed)
            tracks = tuple(self._track(number) for number in range(len(self.now.tracks)))
            self.now = self.now.taken_back(tracks, again)

    def _track(self, number: int) -> Track:
        """Recompute a track from its stored answers."""
        track = self._start.tracks[number]
        for answered in self._answers.values():
            if answered.track == number:
                track = track.answered(correct=answered.correct, at_level=answered.level)
        return track
