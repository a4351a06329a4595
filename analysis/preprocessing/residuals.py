"""Compute residuals of log estimates, and regression slopes per participant."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy import special

from slipscale.analysis.preprocessing.sufficiency import TINY
from slipscale.experiments.dataset.schema import PARTICIPANT


def residuals(trials: pd.DataFrame, logs: pd.DataFrame) -> NDArray[np.float64]:
    """Return one residual per trial: the log estimate without participant and amplitude effects.

    Parameters
    ----------
    trials : DataFrame
        Trials, with the logarithm of each estimate in the column ``log``.
    logs : DataFrame, shape (participants, amplitudes)
        Mean logarithms.
    """
    who = logs.index.get_indexer(pd.Index(trials[PARTICIPANT]))
    what = logs.columns.get_indexer(pd.Index(trials["level"]))
    table = logs.to_numpy(float)
    with warnings.catch_warnings():
        # The mean is empty for participants and amplitudes without logarithms, whose trials are not
        # used.
        warnings.filterwarnings("ignore", "Mean of empty slice", RuntimeWarning)
        rows, columns = np.nanmean(table, axis=1), np.nanmean(table, axis=0)
    grand = np.nanmean(columns) if np.isfinite(columns).any() else np.nan
    return np.asarray(trials["log"].to_numpy(float) - rows[who] - columns[what] + grand)


def slopes_per_participant(
    who: NDArray[np.intp],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    people: int,
    part: NDArray[np.intp] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return each participant's slope of y on x and its p-value; NaN if x is constant.

    Parameters
    ----------
    who : int array, shape (trials,)
        Participant indices, 0 to ``people`` - 1.
    part : int array, shape (trials,), optional
        Indices of parts within participants, such as conditions, between which x and y may differ.
    """
    here = np.isfinite(x) & np.isfinite(y)
    who, x, y = who[here], x[here], y[here]
    parts, within = (people, who) if part is None else _numbered(who, part[here])

    def total(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.bincount(who, values, people), float)

    def centred(values: NDArray[np.float64]) -> NDArray[np.float64]:
        sizes = np.maximum(np.bincount(within, minlength=parts), 1)
        return np.asarray(values - (np.bincount(within, values, parts) / sizes)[within])

    dx, dy = centred(x), centred(y)
    means = np.bincount(who[np.unique(within, return_index=True)[1]], minlength=people)
    df = total(np.ones_like(x)) - means - 1
    squares = total(dx * dx)
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.where(squares > TINY, total(dx * dy) / squares, np.nan)
        left = np.maximum(total(dy * dy) - slope**2 * squares, 0)
        t = np.abs(slope) * np.sqrt(np.maximum(df, 0) * squares / left)
    return slope, 2 * special.stdtr(np.maximum(df, 1), -t)


def _numbered(who: NDArray[np.intp], part: NDArray[np.intp]) -> tuple[int, NDArray[np.intp]]:
    """Return the number of different pairs, and the index of each trial's pair."""
    pairs, index = np.unique(np.column_stack([who, part]), axis=0, return_inverse=True)
    return len(pairs), index.reshape(-1)
