"""Table III and further descriptive statistics of estimates.

A *value* is one participant's arithmetic mean at one amplitude: participants are the sample.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from analysis.preprocessing.normalisation import complete

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Fewer participants than this give no interval.
FEWEST = 3
#: The two conventions of the standard deviation, as numpy's ``ddof``.
SD_CONVENTIONS = {"sample": 1, "population": 0}


def table3(cells: pd.DataFrame, standard_deviation: str = "sample") -> pd.DataFrame:
    """Return the paper's three statistics per amplitude.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean estimates, see `analysis.preprocessing.normalisation.cell_means`.
    standard_deviation : {"sample", "population"}
        Divide by n - 1 or by n.

    Returns
    -------
    DataFrame
        ``amplitude_um_pp n mean maximum_deviation standard_deviation``; the maximum deviation
        is max |value - mean| over participants. The standard deviation of one value is NaN
        (sample) or 0 (population).
    """
    found = over_participants(cells, standard_deviation)
    found.insert(0, "amplitude_um_pp", cells.columns.to_numpy(float))
    return found


def over_participants(cells: pd.DataFrame, standard_deviation: str = "sample") -> pd.DataFrame:
    """Return ``n mean maximum_deviation standard_deviation``, one row a column of the cells."""
    values = cells.to_numpy(float)
    count = np.sum(~np.isnan(values), axis=0)
    mean = cells.mean().to_numpy(float)
    deviation = np.abs(values - mean)
    return pd.DataFrame(
        {
            "n": count,
            "mean": mean,
            "maximum_deviation": np.nanmax(deviation, axis=0) if len(values) else mean,
            "standard_deviation": cells.std(ddof=SD_CONVENTIONS[standard_deviation]).to_numpy(),
        }
    )


def cousineau_morey(values: NDArray[np.float64], confidence: float = 0.95) -> NDArray[np.float64]:
    """Return half-widths of within-participant confidence intervals, one per column.

    Each participant's values are shifted to the grand mean (Cousineau 2005, Tutor. Quant.
    Methods Psychol. 1, 42-45), the variance corrected by k / (k - 1) (Morey 2008, ibid. 4,
    61-64), the interval is Student's.

    Parameters
    ----------
    values : array, shape (participants, conditions)
        Complete. NaN for fewer than `FEWEST` participants or two conditions.
    """
    from scipy import stats  # noqa: PLC0415 - a second's import, only when an interval is asked for

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
    resamples: int = 5000,
    seed: int = 2007,
) -> pd.DataFrame:
    """Return all descriptive statistics per amplitude.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Participants' mean estimates.
    logs : DataFrame, shape (participants, amplitudes)
        Participants' mean natural logarithms, for the geometric means.
    confidence : float
        Of the intervals.
    resamples, seed : int
        Of the bootstrap over participants.

    Returns
    -------
    DataFrame
        ``amplitude_um_pp n mean geometric_mean median sd_sample sd_population
        maximum_deviation within_low within_high bootstrap_low bootstrap_high``. Within:
        Cousineau-Morey around the mean of all; bootstrap: percentile interval of the mean.
    """
    table = table3(cells).rename(columns={"standard_deviation": "sd_sample"})
    whole = complete(cells).to_numpy(float)
    half = cousineau_morey(whole, confidence) if len(whole) else np.full(cells.shape[1], np.nan)
    low, high = bootstrap_means(cells, confidence, resamples, seed)
    geometric = np.exp(logs.mean()).reindex(cells.columns).to_numpy(float)
    return table.assign(
        sd_population=cells.std(ddof=0).to_numpy(float),
        geometric_mean=geometric,
        median=cells.median().to_numpy(float),
        within_low=table["mean"] - half,
        within_high=table["mean"] + half,
        bootstrap_low=low,
        bootstrap_high=high,
    )


def bootstrap_means(
    cells: pd.DataFrame, confidence: float, resamples: int, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return percentile intervals of the means, participants resampled; NaN for too few."""
    from scipy import stats  # noqa: PLC0415 - a second's import

    low = np.full(cells.shape[1], np.nan)
    high = low.copy()
    for place, column in enumerate(cells.to_numpy(float).T):
        values = column[~np.isnan(column)]
        if len(values) < FEWEST or np.ptp(values) == 0:
            continue
        found = stats.bootstrap(
            (values,),
            np.mean,
            n_resamples=resamples,
            batch=max(1, 1_000_000 // len(values)),
            confidence_level=confidence,
            method="percentile",
            rng=np.random.default_rng(seed),
        ).confidence_interval
        low[place], high[place] = found.low, found.high
    return low, high
