"""Test whether estimates differ between amplitudes: ANOVA, Friedman's test and trend tests.

Each test takes a `Prepared` object and returns its result or `NotComputed`. The tests first check
for constant data and for too few participants or conditions, because SciPy would return NaN.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import OurName, bounds, record, renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.effect_sizes import eta_squared, eta_squared_interval
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.repeated_measures import batched
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval

#: Largest sample for which SciPy's p-value of the Shapiro-Wilk test is accurate.
SHAPIRO_AT_MOST = 5000


@dataclass(frozen=True, slots=True, kw_only=True)
class RmAnova:
    """A repeated-measures analysis of variance of mean log estimates.

    Parameters
    ----------
    F, df1, df2, p : float, int, int, float
        F test without a correction for violations of sphericity.
    epsilon_gg, p_gg : float
        Greenhouse–Geisser epsilon, and the p-value corrected with it.
    epsilon_hf, p_hf : float
        Huynh–Feldt epsilon, and the p-value corrected with it.
    eta2_generalised : float
        Generalised eta squared.
    eta2_generalised_interval : ConfidenceInterval or None
        Interval for generalised eta squared, or None if it is not defined.
    mauchly_w, mauchly_p : float or None
        Mauchly's test of sphericity. Both are None with two amplitudes, because sphericity always
        holds, and with fewer participants than amplitudes, because the test is not defined.
    shapiro_w, shapiro_p : float or None
        Shapiro-Wilk test of the residuals' normality, or None if there are too many values for
        SciPy.
    n, n_incomplete : int
        Number of participants tested, and number excluded because they have no log estimate at some
        amplitude.
    levels, left_out_levels : tuple of float
        Amplitudes that are compared, and amplitudes that are omitted because every estimate is
        zero.
    """

    F: float
    df1: int
    df2: int
    p: float
    epsilon_gg: float
    p_gg: float
    epsilon_hf: float
    p_hf: float
    eta2_generalised: float
    eta2_generalised_interval: ConfidenceInterval | None
    mauchly_w: float | None
    mauchly_p: float | None
    shapiro_w: float | None
    shapiro_p: float | None
    n: int
    n_incomplete: int
    levels: tuple[float, ...]
    left_out_levels: tuple[float, ...]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        keys = {"scale": "log", **renamed(self, eta2_generalised_interval="eta2_generalised_ci")}
        keys["eta2_generalised_ci"] = bounds(self.eta2_generalised_interval)
        if self.shapiro_p is None:
            del keys["shapiro_w"], keys["shapiro_p"]
        return keys


#: The error rate of `friedman_of`, for the methods. The F form of Iman and Davenport (1980) is
#: significant in up to .20 of studies without an effect (3 participants, 3 conditions).
FRIEDMAN_ERRORS = (
    "Friedman's test used the χ² form, which is significant in 2 to 6 % of simulated studies "
    "without a difference (3 to 24 participants, equal or unequal spreads)."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Friedman:
    """The result of Friedman's rank test, with Kendall's W as effect size."""

    chi2: float
    df: int
    p: float
    kendalls_w: float
    n: int
    n_incomplete: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PageTrend:
    """The result of Page's trend test, with a one-sided p-value and the method that SciPy used."""

    L: float
    p: float
    method: str
    n: int
    n_incomplete: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearTrend:
    """The linear trend of mean log estimates with amplitude.

    Parameters
    ----------
    log_slope_per_level : MeanOverParticipants or NotComputed
        Change in the natural logarithm of the estimate per µm peak to peak.
    n, n_incomplete : int
        Number of participants tested, and number excluded because they have no log estimate at some
        amplitude.
    """

    log_slope_per_level: MeanOverParticipants | NotComputed
    n: int
    n_incomplete: int

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return {
            "unit": OurName("natural logarithm per unit_of_level"),
            **record(self.log_slope_per_level),
            "n": self.n,
            "n_incomplete": self.n_incomplete,
        }


def lacking(
    table: pd.DataFrame, conditions: int = 2, quantity: Quantity = PLATE_AMPLITUDE
) -> str | None:
    """Return the reason why a table of participants by amplitudes cannot be tested, or None."""
    n, k = table.shape
    if k < conditions:
        return few(quantity.levels, k, conditions)
    if n < FEWEST:
        return few(f"participants with a usable estimate at every {quantity.level}", n)
    return None


def additive_residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the residuals after removing the means of participants and of amplitudes."""
    rows, columns = values.mean(axis=1, keepdims=True), values.mean(axis=0, keepdims=True)
    return np.asarray(values - rows - columns + values.mean())


def _is_constant(values: NDArray[np.float64]) -> bool:
    scale = max(float(np.abs(values).max()), 1.0)
    return bool(np.abs(additive_residuals(values)).max() <= TINY * scale)


def log_table(data: Prepared) -> tuple[pd.DataFrame, str | None]:
    """Return the complete table of mean logarithms, and the reason if it cannot be tested."""
    table = data.whole_logs
    if data.refused:
        return table, data.zero_sentence
    return table, lacking(table, 2, data.quantity)


def _no_ranks(table: pd.DataFrame, quantity: Quantity) -> str | None:
    """Return the reason why a rank test of a complete table is impossible, or None."""
    why = lacking(table, 3, quantity)
    if why is None and (np.ptp(table.to_numpy(float), axis=1) == 0).all():
        why = "the estimates of each participant are all the same"
    return why


def _incomplete(data: Prepared, table: pd.DataFrame) -> int:
    return len(data.cells) - len(table)


def rm_anova(data: Prepared) -> RmAnova | NotComputed:
    """Perform a repeated-measures analysis of variance on participants' mean logarithms.

    Sphericity is tested with Mauchly's test. P-values are also given with the Greenhouse-Geisser
    and Huynh-Feldt corrections. The effect size is generalised eta squared (see
    `slipscale.analysis.statistics.effect_sizes`). pingouin is not used, because its import takes
    longer than the whole computation.
    """
    from scipy import stats

    table, why = log_table(data)
    if why:
        return NotComputed(why)
    values = table.to_numpy(float)
    if _is_constant(values):
        return NotComputed(
            "no variance remains after removing the means of participants and "
            f"{data.quantity.levels}"
        )
    df1 = values.shape[1] - 1
    df2 = df1 * (len(values) - 1)
    f = float(batched.repeated_measures_f(values[None])[0])
    epsilon = float(batched.greenhouse_geisser(values[None])[0]) if df1 > 1 else 1.0
    epsilon_hf = _huynh_feldt(epsilon, len(values), df1) if df1 > 1 else 1.0
    # W is a determinant; with fewer participants than amplitudes, it is always 0.
    sphericity = _mauchly(values) if 1 < df1 < len(values) else None
    residuals = additive_residuals(values).ravel()
    normality = stats.shapiro(residuals) if residuals.size <= SHAPIRO_AT_MOST else None
    return RmAnova(
        F=f,
        df1=df1,
        df2=df2,
        p=float(stats.f.sf(f, df1, df2)),
        epsilon_gg=epsilon,
        p_gg=float(stats.f.sf(f, df1 * epsilon, df2 * epsilon)),
        epsilon_hf=epsilon_hf,
        p_hf=float(stats.f.sf(f, df1 * epsilon_hf, df2 * epsilon_hf)),
        eta2_generalised=eta_squared(values),
        eta2_generalised_interval=eta_squared_interval(values, data.choices.confidence),
        mauchly_w=sphericity[0] if sphericity else None,
        mauchly_p=sphericity[1] if sphericity else None,
        shapiro_w=float(normality.statistic) if normality else None,
        shapiro_p=float(normality.pvalue) if normality else None,
        n=len(table),
        n_incomplete=_incomplete(data, table),
        levels=tuple(data.logged),
        left_out_levels=tuple(
            amplitude
            for amplitude in data.cells.columns.to_numpy(float).tolist()
            if amplitude not in data.logged
        ),
    )


def friedman(data: Prepared) -> Friedman | NotComputed:
    """Perform Friedman's rank test on mean estimates, and compute Kendall's W.

    Zeros and differences between participants' scales do not affect the test.
    """
    return friedman_of(data.whole, _incomplete(data, data.whole), data.quantity)


def friedman_of(
    table: pd.DataFrame, n_incomplete: int, quantity: Quantity = PLATE_AMPLITUDE
) -> Friedman | NotComputed:
    """Return Friedman's rank test for a complete table of participants by conditions."""
    from scipy import stats

    if why := _no_ranks(table, quantity):
        return NotComputed(why)
    values = table.to_numpy(float)
    found = stats.friedmanchisquare(*values.T)
    n, k = values.shape
    return Friedman(
        chi2=float(found.statistic),
        df=k - 1,
        p=float(found.pvalue),
        kendalls_w=float(found.statistic) / (n * (k - 1)),
        n=n,
        n_incomplete=n_incomplete,
    )


def page_trend(data: Prepared) -> PageTrend | NotComputed:
    """Perform Page's one-sided test for a trend of estimates with amplitude."""
    return page_trend_of(data.whole, _incomplete(data, data.whole), data.quantity)


def page_trend_of(
    table: pd.DataFrame, n_incomplete: int, quantity: Quantity = PLATE_AMPLITUDE
) -> PageTrend | NotComputed:
    """Return Page's test for a complete table of participants by conditions in ascending order.

    If the rated property decreases with the level, the expected trend is downwards.
    """
    from scipy import stats

    if why := _no_ranks(table, quantity):
        return NotComputed(why)
    values = table.to_numpy(float)[:, :: -1 if quantity.falls else 1]
    found = stats.page_trend_test(values)
    return PageTrend(
        L=float(found.statistic),
        p=float(found.pvalue),
        method=str(found.method),
        n=len(table),
        n_incomplete=n_incomplete,
    )


def linear_trend(data: Prepared) -> LinearTrend | NotComputed:
    """Test the linear trend of mean logarithms with amplitude, using one slope per participant."""
    table, why = log_table(data)
    if why:
        return NotComputed(why)
    amplitudes = table.columns.to_numpy(float)
    weights = amplitudes - amplitudes.mean()
    slopes = table.to_numpy(float) @ (weights / (weights**2).sum())
    return LinearTrend(
        log_slope_per_level=mean_over_participants(slopes, data.choices.confidence),
        n=len(table),
        n_incomplete=_incomplete(data, table),
    )


def _huynh_feldt(epsilon_gg: float, n: int, df1: int) -> float:
    return min((n * df1 * epsilon_gg - 2) / (df1 * (n - 1 - df1 * epsilon_gg)), 1.0)


def _mauchly(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return W and p of Mauchly's test, with the second-order term of R's ``mauchly.test``."""
    from scipy import linalg, stats

    n, k = len(values) - 1, values.shape[1]
    d = k - 1
    contrasts = linalg.helmert(k)
    spread = contrasts @ np.cov(values, rowvar=False) @ contrasts.T
    sign, log_determinant = np.linalg.slogdet(spread)
    log_w = log_determinant - d * np.log(np.trace(spread) / d) if sign > 0 else -np.inf
    df = d * (d + 1) / 2 - 1
    scale = 1 - (2 * d**2 + d + 2) / (6 * d * n)
    second = (d + 2) * (d - 1) * (d - 2) * (2 * d**3 + 6 * d**2 + 3 * k + 2)
    second /= 288 * (n * d * scale) ** 2
    first, corrected = stats.chi2.sf(-n * scale * log_w, (df, df + 4))
    return float(np.exp(log_w)), float(first + second * (corrected - first))
