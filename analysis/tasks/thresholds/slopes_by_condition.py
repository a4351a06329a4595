"""Compare the slopes of comparisons between conditions, such as with and without vibration.

Each participant's curve is fitted in each condition without lapses, as by probit regression,
because few answers do not determine a slope and a lapse rate. The logarithms of the slopes are
compared by paired t tests with Holm's correction.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pandas as pd

from slipscale.analysis.reading.surface_labels import numbers_first
from slipscale.analysis.reading.trial_tables import FACTOR, factor_columns
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    holm_of,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.psychometric_function import Answers
from slipscale.analysis.statistics.psychometrics.thresholds import fit_threshold
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeContrast:
    """Comparison of the slopes in two conditions.

    Parameters
    ----------
    first, second : str
    log_ratio : MeanOverParticipants or NotComputed
        Mean difference of the natural logarithms of participants' slopes, second minus first.
    p_holm : float or None
        Holm-corrected p-value across the factor's pairs.
    """

    first: str
    second: str
    log_ratio: MeanOverParticipants | NotComputed
    p_holm: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopesByCondition:
    """Slopes in the conditions of one factor.

    Parameters
    ----------
    name : str
        Name of the factor.
    half_widths_level : dict of str to float
        Half the distance between the 25 % and 75 % points in each condition: geometric means across
        participants.
    points_level : dict of str to float
        Level at which half of the answers are "more" in each condition: means across participants.
    contrasts : tuple of SlopeContrast
    """

    name: str
    half_widths_level: dict[str, float]
    points_level: dict[str, float]
    contrasts: tuple[SlopeContrast, ...]


def slopes_by_condition(
    rows: pd.DataFrame, *, method: str, curve: str, confidence: float
) -> Iterator[SlopesByCondition]:
    """Yield the slopes for each factor of a comparison on a linear axis."""
    if method != "comparison" or CURVES[curve].logarithmic:
        return
    low, high = CURVES[curve].inverse(np.array([0.25, 0.75]))
    for column in factor_columns(rows):
        labels = sorted(rows[column].astype(str).unique(), key=numbers_first)
        if len(labels) < 2:  # noqa: PLR2004 - several
            continue
        fits = {
            label: _fits(rows[rows[column].astype(str) == label], method, curve) for label in labels
        }
        logs = {label: own["log_slope"] for label, own in fits.items()}
        pairs = list(combinations(labels, 2))
        found = [
            mean_over_participants(np.array(logs[second] - logs[first], float), confidence)
            for first, second in pairs
        ]
        half = {label: float((high - low) / 2 / np.exp(own.mean())) for label, own in logs.items()}
        contrasts = [
            SlopeContrast(first=first, second=second, log_ratio=ratio)
            for (first, second), ratio in zip(pairs, found, strict=True)
        ]
        yield SlopesByCondition(
            name=column.removeprefix(FACTOR),
            half_widths_level=half,
            points_level={label: float(own["point"].mean()) for label, own in fits.items()},
            contrasts=tuple(
                replace(each, p_holm=p) for each, p in zip(contrasts, holm_of(found), strict=True)
            ),
        )


def _fits(rows: pd.DataFrame, method: str, curve: str) -> pd.DataFrame:
    """Return the logarithm of each participant's slope, and the point of subjective equality.

    They are NaN if the slope is not determined.
    """
    found = {}
    for who, own in rows.groupby(rows[PARTICIPANT].astype(str)):
        answers = Answers.of_trials(own["track_level"].tolist(), own["correct"].tolist())
        fit = fit_threshold(answers, method=method, curve=curve, largest_lapse=0.0)
        if fit and fit.slope:
            found[str(who)] = (float(np.log(fit.slope_value)), fit.threshold_level.value)
        else:
            found[str(who)] = (np.nan, np.nan)
    return pd.DataFrame.from_dict(found, "index", dtype=float, columns=["log_slope", "point"])
