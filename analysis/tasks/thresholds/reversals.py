"""Estimate the threshold of a staircase as the mean of its last reversals.

The method follows Levitt (1971, Journal of the Acoustical Society of America 49, 467-477). The
recorded answers of each track are replayed with the rule in the study file. The reversals are
therefore those of the session, even if a trial was voided later. Tracks are separate for each
condition, session and run. Tracks with fewer reversals than requested are omitted and counted.

A participant's value is the mean across tracks (the geometric mean on a logarithmic scale). The
value estimates the level at which steps up and down balance (`UpDown.target`), not the midpoint of
the fitted curve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.analysis.reading.trial_tables import factor_columns
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed, fold
from slipscale.analysis.statistics.psychometrics.psychometric_function import Estimate, estimate
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
from slipscale.experiments.protocol_parts.adaptive.up_down import UpDownTrack


@dataclass(frozen=True, slots=True, kw_only=True)
class PersonReversals:
    """A participant's mean reversal level in a condition; NaN if no track has enough reversals."""

    participant: str
    mean_level: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionReversals:
    """Mean reversal levels in one condition.

    Parameters
    ----------
    condition : str
        Levels of the factors; empty without factors.
    tracks, left_out : int
        Counts of all tracks, and of tracks with too few reversals.
    mean_level : Estimate or NotComputed
        Mean across participants, with a t-based interval.
    people : tuple of PersonReversals
    """

    condition: str
    tracks: int
    left_out: int
    mean_level: Estimate | NotComputed
    people: tuple[PersonReversals, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reversals:
    """Means of the last reversals of a staircase.

    Parameters
    ----------
    last : int
        Number of reversals per track.
    proportion : float
        Proportion of correct answers at which steps up and down balance.
    conditions : tuple of ConditionReversals
    """

    last: int
    proportion: float
    conditions: tuple[ConditionReversals, ...]


def reversals(
    main: pd.DataFrame, rule: Interleaved | None, last: int | None, confidence: float
) -> Reversals | NotComputed:
    """Return the mean levels at the last reversals.

    Parameters
    ----------
    main : DataFrame
        Main trials of one task without catch trials, in order of presentation.
    rule : Interleaved or None
        The tracks' state before the first trial; None if unknown.
    last : int or None
        Number of reversals per track; None if not requested in the study file.
    confidence : float
        Confidence level of the intervals.
    """
    if last is None:
        return NotComputed("the study file does not set threshold_reversals")
    if rule is None:
        return NotComputed("the data do not record the rule that determined the levels")
    before = rule.tracks[0]
    if not isinstance(before, UpDownTrack):
        return NotComputed("QUEST+ has no reversals")
    factors = factor_columns(main)
    names = main[factors].astype(str).agg(" ".join, axis=1) if factors else main["task"].map(_plain)
    return Reversals(
        last=last,
        proportion=before.rule.target,
        conditions=tuple(
            _condition(str(name), rows, before, last, confidence)
            for name, rows in main.groupby(names, sort=True)
        ),
    )


def _plain(_task: object) -> str:
    return ""


def _condition(
    name: str, rows: pd.DataFrame, before: UpDownTrack, last: int, confidence: float
) -> ConditionReversals:
    rule = before.rule
    own: dict[str, list[float]] = {}
    tracks = 0
    by = [PARTICIPANT, "session", "run", "track"]
    for (who, *_), track in rows.groupby(by, observed=True, dropna=False, sort=True):
        tracks += 1
        levels = _replayed(before, track["correct"].tolist())[-last:]
        means = own.setdefault(str(who), [])
        if len(levels) == last:
            means.append(float(np.mean([rule.coordinate(level) for level in levels])))
    values = np.array([np.mean(each) if each else np.nan for each in own.values()])
    found = mean_over_participants(values, confidence)

    def estimated(mean: MeanOverParticipants) -> Estimate | NotComputed:
        ends = [rule.level_at(each) for each in (mean.mean, *mean.interval)]
        return estimate(np.array(ends), confidence)

    return ConditionReversals(
        condition=name,
        tracks=tracks,
        left_out=tracks - sum(map(len, own.values())),
        mean_level=fold(found, estimated, NotComputed),
        people=tuple(
            PersonReversals(participant=who, mean_level=float(rule.level_at(value)))
            for who, value in zip(own, values, strict=True)
        ),
    )


def _replayed(track: UpDownTrack, answers: list[bool]) -> tuple[float, ...]:
    """Return the levels at which a track reversed, given its answers."""
    for correct in answers:
        track = track.answered(correct=bool(correct))
    return track.reversal_levels
