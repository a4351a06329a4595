"""Compute Table III of the paper and other descriptive statistics of estimates.

Each value is the arithmetic mean of one participant's estimates at one amplitude.
"""

from __future__ import annotations

from math import inf

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from slipscale.analysis.preprocessing.normalisation import complete
from slipscale.analysis.preprocessing.sufficiency import TINY

#: Minimum number of participants for an interval.
FEWEST = 3
#: Conventions for the standard deviation -> NumPy's ``ddof``.
SD_CONVENTIONS = {"sample": 1, "population": 0}


def means_and_spreads(cells: pd.DataFrame, standard_deviation: str = "sample") -> pd.DataFrame:
    """Return the statistics of the paper's Table III, with one row per amplitude.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean estimates; see
        `slipscale.analysis.preprocessing.normalisation.cell_means`.
    standard_deviation : {"sample", "population"}
        Whether the standard deviation divides by n - 1 or by n.

    Returns
    -------
    DataFrame
        Columns ``level n mean maximum_deviation standard_deviation``. The maximum
        deviation is max |value - mean| across participants. With one participant, the maximum
        deviation is NaN, and the standard deviation is NaN (sample) or 0 (population).
    """
    found = over_participants(cells, standard_deviation)
    found.insert(0, "level", cells.columns.to_numpy(float))
    return found


def over_participants(cells: pd.DataFrame, standard_deviation: str = "sample") -> pd.DataFrame:
    """Return the n, mean, maximum deviation and standard deviation of each column of ``cells``."""
    values = cells.to_numpy(float)
    count = np.sum(~np.isnan(values), axis=0)
    mean = cells.mean().to_numpy(float)
    deviation = np.nan_to_num(np.abs(values - mean))
    return pd.DataFrame(
        {
            "n": count,
            "mean": mean,
            # A single value is its own mean, so its deviation says nothing.
            "maximum_deviation": np.where(count > 1, deviation.max(axis=0, initial=0.0), np.nan),
            "standard_deviation": cells.std(ddof=SD_CONVENTIONS[standard_deviation]).to_numpy(),
        }
    )


def cousineau_morey(values: NDArray[np.float64], confidence: float = 0.95) -> NDArray[np.float64]:
    """Return half-widths of Cousineau–Morey within-participant intervals, one per condition.

    Each participant's values are shifted to the grand mean (Cousineau 2005, Tutorials in
    Quantitative Methods for Psychology 1, 42-45), the variance is corrected by k / (k - 1) (Morey
    2008, ibid. 4, 61-64), and the half-width uses the t distribution.

    Parameters
    ----------
    values : array, shape (participants, conditions)
        Values; missing values are not allowed. With fewer than `FEWEST` participants or fewer than
        two conditions, the half-widths are NaN.
    """
    from scipy import stats

    n, k = values.shape
    if n < FEWEST or k < 2:  # noqa: PLR2004
        return np.full(k, np.nan)
    shifted = values - values.mean(axis=1, keepdims=True) + values.mean()
    standard_error = shifted.std(axis=0, ddof=1) * np.sqrt(k / (k - 1)) / np.sqrt(n)
    return np.asarray(standard_error * stats.t.ppf((1 + confidence) / 2, n - 1))


def describe(
    cells: pd.DataFrame,
    logs: pd.DataFrame,
    *,
    confidence: float = 0.95,
    most: float = inf,
) -> pd.DataFrame:
    """Return all descriptive statistics, with one row per amplitude.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean estimates.
    logs : DataFrame, shape (participants, amplitudes)
        Participants' mean natural logarithms, used for the geometric means.
    confidence : float
        Confidence level of the intervals.
    most : float
        Largest possible mean, such as 100 % of a participant's maximum. Estimates are not negative,
        so that intervals are limited to 0 to ``most``.

    Returns
    -------
    DataFrame
        Columns ``level n mean geometric_mean median sd_sample sd_population
        maximum_deviation mean_low mean_high geometric_n geometric_low geometric_high within_low
        within_high``. The intervals of the mean and of the geometric mean are t-based.
        ``within_low`` and ``within_high`` are computed by `within_intervals`.
    """
    table = means_and_spreads(cells).rename(columns={"standard_deviation": "sd_sample"})
    logs = logs.reindex(columns=cells.columns)
    mean_low, mean_high = student_intervals(cells, confidence)
    low, high = student_intervals(logs, confidence)
    within = within_intervals(logs, confidence)
    return table.assign(
        mean_low=np.maximum(mean_low, 0.0),
        mean_high=np.minimum(mean_high, most),
        sd_population=cells.std(ddof=0).to_numpy(float),
        geometric_n=logs.notna().sum().to_numpy(int),
        geometric_mean=np.exp(logs.mean()).to_numpy(float),
        geometric_low=np.exp(low),
        geometric_high=np.minimum(np.exp(high), most),
        within_low=within[0],
        within_high=np.minimum(within[1], most),
        median=cells.median().to_numpy(float),
    )


def within_intervals(
    logs: pd.DataFrame, confidence: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return within-participant intervals of the geometric means, one per amplitude.

    The intervals are computed on logarithms with the Cousineau–Morey method and transformed back.
    The spread of estimates is proportional to their size, so only logarithms have a common variance
    at all amplitudes. If raw means were used, the intervals of small means would extend below 0.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Mean natural logarithms. Amplitudes with a missing value are excluded. If fewer than two
        amplitudes remain, participants with missing values are excluded instead.
    """
    some = logs.columns[logs.notna().all()]
    if len(some) < 2:  # noqa: PLR2004
        some = logs.columns[logs.notna().any()]
    whole = complete(logs[some])
    centre = logs.mean()
    half = pd.Series(np.nan, index=logs.columns)
    if len(whole):
        half[some] = cousineau_morey(whole.to_numpy(float), confidence)
    return np.exp((centre - half).to_numpy(float)), np.exp((centre + half).to_numpy(float))


def student_intervals(
    table: pd.DataFrame, confidence: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return t-based intervals for the column means.

    The interval is NaN with fewer than `FEWEST` values, or if all values are equal.

    For small, skewed samples, these intervals have better coverage than percentile or BCa bootstrap
    intervals (docs/validation/measured/statistics.md).
    """
    from scipy import stats

    n = table.notna().sum().to_numpy(float)
    error = table.std(ddof=1).to_numpy(float) / np.sqrt(np.maximum(n, 1))
    half = stats.t.ppf((1 + confidence) / 2, np.maximum(n - 1, 1)) * error
    centre = table.mean().to_numpy(float)
    # Equal means can differ in the last bits.
    differ = error > TINY * np.maximum(np.abs(centre), 1.0)
    half = np.where((n >= FEWEST) & differ, half, np.nan)
    return centre - half, centre + half
