"""Stopping rules for tracks: number of trials, number of reversals, or posterior certainty."""

from __future__ import annotations

from dataclasses import dataclass

from slipscale.experiments.protocol_parts.adaptive.track import Progress, Track
from slipscale.faults import UserError

#: More trials per track are too many for a participant.
MOST_TRIALS = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class Stopping:
    """Criteria that end a track as soon as one of them is met.

    Parameters
    ----------
    most_trials : int
        Maximum number of answers, after which the track always ends.
    reversals : int or None
        Number of direction changes after which the track ends.
    threshold_sd_log10 : float or None
        Posterior standard deviation of the threshold at which the track ends, in decades.
    least_trials : int
        Minimum number of answers before ``reversals`` or ``threshold_sd_log10`` can end the track.

    Raises
    ------
    UserError
        If a parameter is out of range, or a criterion cannot be met within ``most_trials``.
    """

    most_trials: int
    reversals: int | None = None
    threshold_sd_log10: float | None = None
    least_trials: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.most_trials <= MOST_TRIALS:
            raise UserError(
                "stopping: most_trials is {most_trials}, expected 1 to {limit}",
                most_trials=self.most_trials,
                limit=MOST_TRIALS,
            )
        if not 1 <= self.least_trials <= self.most_trials:
            raise UserError(
                "stopping: least_trials is {least_trials}, expected 1 to most_trials "
                "({most_trials})",
                least_trials=self.least_trials,
                most_trials=self.most_trials,
            )
        if self.reversals is not None and self.reversals < 1:
            raise UserError(
                "stopping: reversals is {reversals}, expected 1 or more", reversals=self.reversals
            )
        if self.threshold_sd_log10 is not None and not self.threshold_sd_log10 > 0:
            raise UserError(
                "stopping: threshold_sd_log10 is {threshold_sd_log10}, expected above 0",
                threshold_sd_log10=self.threshold_sd_log10,
            )
        # The first step cannot be a reversal, so n reversals take at least n + 1 steps.
        if self.reversals is not None and self.reversals >= self.most_trials:
            raise UserError(
                "stopping: {reversals} reversals take at least {least_trials} trials, but "
                "most_trials is {most_trials}: this rule could never stop",
                reversals=self.reversals,
                least_trials=self.reversals + 1,
                most_trials=self.most_trials,
            )

    def check(self, track: Track) -> None:
        """Raise `UserError` if a criterion can never be met, or is met before the first trial."""
        progress = track.progress
        for name in ("reversals", "threshold_sd_log10"):
            if getattr(self, name) is not None and getattr(progress, name) is None:
                raise UserError(
                    "stopping: this method has no {name}, so this rule could never stop a track; "
                    "use another rule, or most_trials alone",
                    name=name,
                )
        wanted, known = self.threshold_sd_log10, progress.threshold_sd_log10
        if wanted is not None and known is not None and known <= wanted:
            raise UserError(
                "stopping: threshold_sd_log10 is {wanted:g}, but the grid of thresholds has a "
                "spread of {spread:.3g} before any answer; expected a smaller value",
                wanted=wanted,
                spread=known,
            )

    def reason(self, progress: Progress) -> str | None:
        """Return the criterion that ended the track, or None if the track continues."""
        if progress.trials >= self.least_trials:
            reversals, spread = progress.reversals, progress.threshold_sd_log10
            if self.reversals is not None and reversals is not None and reversals >= self.reversals:
                return "reversals"
            limit = self.threshold_sd_log10
            if limit is not None and spread is not None and spread <= limit:
                return "threshold_sd_log10"
        return "most_trials" if progress.trials >= self.most_trials else None
