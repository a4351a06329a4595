"""Tests on magnitude estimates: called from SciPy, statsmodels and pingouin, with their traps shut.

Each test takes a `Prepared` and returns its numbers, or ``{"reason": ...}``: constant data, too
few participants or conditions are checked first, because the libraries answer them with a
silent NaN. Tables of tests at the end say which there are.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.preprocessing.sufficiency import FEWEST, TINY, few
from analysis.statistics.effect_sizes import eta_squared_interval

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from analysis.preprocessing.log_transform import Prepared

Result = dict[str, Any]


def reason(text: str) -> Result:
    """Return what stands in place of a result that could not be computed."""
    return {"reason": text}


def interval_name(confidence: float) -> str:
    """Return the key of an interval in inference.json: "ci95" only where it is one."""
    return "ci95" if confidence == 0.95 else "ci"  # noqa: PLR2004


def lacking(table: pd.DataFrame, conditions: int = 2) -> str | None:
    """Say why a table of participants by amplitudes allows no test, or None."""
    n, k = table.shape
    if k < conditions:
        return few("amplitudes", k, conditions)
    if n < FEWEST:
        return few("participants with a usable estimate at every amplitude", n)
    return None


def additive_residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what participants' and amplitudes' means leave, shape as ``values``."""
    rows, columns = values.mean(axis=1, keepdims=True), values.mean(axis=0, keepdims=True)
    return np.asarray(values - rows - columns + values.mean())


def _is_constant(values: NDArray[np.float64]) -> bool:
    scale = max(float(np.abs(values).max()), 1.0)
    return bool(np.abs(additive_residuals(values)).max() <= TINY * scale)


def log_table(data: Prepared, conditions: int = 2) -> tuple[pd.DataFrame, str | None]:
    """Return the complete table of mean logarithms, and why it allows no test."""
    table = data.whole_logs
    if data.refused:
        return table, data.zero_sentence
    return table, lacking(table, conditions)


def _rank_table(data: Prepared) -> tuple[pd.DataFrame, str | None]:
    """Return the complete table of mean estimates, and why it allows no test on ranks."""
    table = data.whole
    why = lacking(table, 3)
    if why is None and (np.ptp(table.to_numpy(float), axis=1) == 0).all():
        why = "every participant's estimates are all the same"
    return table, why


def _dropped(data: Prepared, table: pd.DataFrame) -> dict[str, int]:
    return {"n": len(table), "n_incomplete": len(data.cells) - len(table)}


def rm_anova(data: Prepared) -> Result:
    """Repeated-measures analysis of variance of participants' mean logarithms.

    Sphericity: Mauchly's test; degrees of freedom corrected after Greenhouse and Geisser and
    after Huynh and Feldt. Effect size: generalised eta squared, see
    `analysis.statistics.effect_sizes`. From pingouin and SciPy.
    """
    import pingouin  # noqa: PLC0415 - a second's import
    from scipy import stats  # noqa: PLC0415

    table, why = log_table(data)
    if why:
        return reason(why)
    values = table.to_numpy(float)
    if _is_constant(values):
        return reason("no variance is left beside participants' and amplitudes' means")
    long = _long(table)
    corrected = values.shape[1] > 2  # noqa: PLR2004 - two conditions are always spherical
    with warnings.catch_warnings():
        _mute_known(warnings)
        found = pingouin.rm_anova(
            data=long,
            dv="value",
            within="amplitude",
            subject="who",
            correction=True,
            detailed=True,
            effsize="ng2",
        ).iloc[0]
        epsilon_hf = float(pingouin.epsilon(table, correction="hf")) if corrected else 1.0
        sphericity = pingouin.sphericity(table) if corrected else None
    df1 = values.shape[1] - 1
    df2 = df1 * (len(values) - 1)
    f, epsilon = float(found["F"]), float(found.get("eps", 1.0))
    return {
        "scale": "log",
        "F": f,
        "df1": df1,
        "df2": df2,
        "p": float(stats.f.sf(f, df1, df2)),
        "epsilon_gg": epsilon,
        "p_gg": float(stats.f.sf(f, df1 * epsilon, df2 * epsilon)),
        "epsilon_hf": epsilon_hf,
        "p_hf": float(stats.f.sf(f, df1 * epsilon_hf, df2 * epsilon_hf)),
        "eta2_generalised": float(found["ng2"]),
        "eta2_generalised_ci": eta_squared_interval(values, data.choices.confidence),
        "mauchly_w": float(sphericity.W) if sphericity else None,
        "mauchly_p": float(sphericity.pval) if sphericity else None,
        **_shapiro(values),
        **_dropped(data, table),
    }


def _shapiro(values: NDArray[np.float64]) -> dict[str, float]:
    from scipy import stats  # noqa: PLC0415

    residuals = additive_residuals(values).ravel()
    # SciPy's p is not accurate above 5000 values.
    if residuals.size > 5000:  # noqa: PLR2004
        return {}
    found = stats.shapiro(residuals)
    return {"shapiro_w": float(found.statistic), "shapiro_p": float(found.pvalue)}


def friedman(data: Prepared) -> Result:
    """Friedman's rank test and Kendall's W, on mean estimates: zeros and scales do not matter."""
    from scipy import stats  # noqa: PLC0415

    table, why = _rank_table(data)
    if why:
        return reason(why)
    values = table.to_numpy(float)
    found = stats.friedmanchisquare(*values.T)
    n, k = values.shape
    return {
        "chi2": float(found.statistic),
        "df": k - 1,
        "p": float(found.pvalue),
        "kendalls_w": float(found.statistic) / (n * (k - 1)),
        **_dropped(data, table),
    }


def page_trend(data: Prepared) -> Result:
    """Page's test of an ordered trend: estimates grow with amplitude. One-sided by nature."""
    from scipy import stats  # noqa: PLC0415

    table, why = _rank_table(data)
    if why:
        return reason(why)
    values = table.to_numpy(float)
    found = stats.page_trend_test(values)
    return {
        "L": float(found.statistic),
        "p": float(found.pvalue),
        "method": str(found.method),
        **_dropped(data, table),
    }


def linear_trend(data: Prepared) -> Result:
    """Linear contrast of mean logarithms at the amplitudes' true distances, one a participant."""
    table, why = log_table(data)
    if why:
        return reason(why)
    amplitudes = table.columns.to_numpy(float)
    weights = amplitudes - amplitudes.mean()
    slopes = table.to_numpy(float) @ (weights / (weights**2).sum())
    found = mean_with_interval(slopes, data.choices.confidence)
    return {"unit": "natural logarithm per um_pp", **found, **_dropped(data, table)}


def mean_with_interval(values: NDArray[np.float64], confidence: float) -> Result:
    """Return mean, Student's interval and the test against 0 of one value per participant."""
    from scipy import stats  # noqa: PLC0415

    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        return reason(few("participants", len(values)))
    if np.ptp(values) <= TINY * max(float(np.abs(values).max()), 1.0):
        return reason("all participants have the same value: no spread to judge it by")
    found = stats.ttest_1samp(values, 0.0)
    interval = found.confidence_interval(confidence)
    return {
        "mean": float(values.mean()),
        "ci": [float(interval.low), float(interval.high)],
        "sd": float(values.std(ddof=1)),
        "t": float(found.statistic),
        "df": len(values) - 1,
        "p": float(found.pvalue),
    }


def _long(table: pd.DataFrame) -> pd.DataFrame:
    n, k = table.shape
    return pd.DataFrame(
        {
            "who": np.repeat(np.arange(n), k),
            "amplitude": np.tile(table.columns.to_numpy(float), n),
            "value": table.to_numpy(float).ravel(),
        }
    )


def _mute_known(control: Any) -> None:
    """Mute pingouin's one warning on pandas 3 (dropna in place); no other."""
    control.filterwarnings("ignore", category=pd.errors.Pandas4Warning)


#: Name in inference.json: the test.
TESTS: dict[str, Callable[[Prepared], Any]] = {
    "rm_anova": rm_anova,
    "friedman": friedman,
    "page_trend": page_trend,
    "linear_trend": linear_trend,
}
