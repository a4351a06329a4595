"""Compare groups with possibly unequal variances, by Welch's tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.json_form import renamed
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.effect_sizes import eta2_interval, eta2_of, hedges_g
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.not_computed import NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupMean:
    """The mean of a group, with a t-based interval."""

    group: str
    n: int
    mean: float
    sd: float
    interval: ConfidenceInterval

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupDifference:
    """Comparison of two groups by Welch's t test.

    Parameters
    ----------
    first, second : str
        Names of the groups.
    difference : float
        Difference between means, first minus second.
    interval : ConfidenceInterval
        Welch's interval for the difference.
    t, df, p, p_holm : float
        Two-sided test; ``p_holm`` is Holm-corrected across all pairs of groups.
    hedges_g : float
        Difference divided by the pooled standard deviation, with Hedges' correction.
    hedges_g_interval : ConfidenceInterval or None
        Interval from the non-central t distribution, exact for equal variances; None if not
        defined.
    """

    first: str
    second: str
    difference: float
    interval: ConfidenceInterval
    t: float
    df: float
    p: float
    p_holm: float
    hedges_g: float
    hedges_g_interval: ConfidenceInterval | None

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval="ci", hedges_g_interval="hedges_g_ci")


@dataclass(frozen=True, slots=True, kw_only=True)
class Welch:
    """Welch's analysis of variance between groups, and all pairwise comparisons.

    Parameters
    ----------
    groups : tuple of GroupMean
        Means of the groups, sorted by group name.
    F, df1, df2, p : float
        Welch's F test; with two groups, F is the square of t.
    eta2, eta2_interval : float, ConfidenceInterval or None
        Proportion of variance between groups in an ordinary analysis of variance, and its interval
        from the non-central F distribution.
    pairs : tuple of GroupDifference
        All pairs of groups.
    """

    groups: tuple[GroupMean, ...]
    F: float
    df1: float
    df2: float
    p: float
    eta2: float
    eta2_interval: ConfidenceInterval | None
    pairs: tuple[GroupDifference, ...]

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, eta2_interval="eta2_ci")


def welch(values: Mapping[str, NDArray[np.float64]], confidence: float) -> Welch | NotComputed:
    """Compare the means of groups by Welch's tests.

    The package statsmodels computes the overall test (Welch 1951, Biometrika 38, 330-336), and
    SciPy computes the pairwise tests, which are Holm-corrected.

    Parameters
    ----------
    values : Mapping
        One value per participant, by group. There must be at least two groups of at least three
        participants.
    confidence : float
        Confidence level of all intervals.
    """
    from statsmodels.stats.oneway import anova_oneway

    means: list[GroupMean] = []
    for group, own in values.items():
        mean = mean_over_participants(own, confidence)
        if isinstance(mean, NotComputed):
            return NotComputed(f"group '{group}': {mean.reason}")
        means.append(
            GroupMean(group=group, n=len(own), mean=mean.mean, sd=mean.sd, interval=mean.interval)
        )
    groups = list(values.values())
    unequal = anova_oneway(groups, use_var="unequal", welch_correction=True)
    equal = anova_oneway(groups, use_var="equal")
    ordinary = (float(equal.statistic), float(equal.df[0]), float(equal.df[1]))
    return Welch(
        groups=tuple(means),
        F=float(unequal.statistic),
        df1=float(unequal.df[0]),
        df2=float(unequal.df[1]),
        p=float(unequal.pvalue),
        eta2=eta2_of(*ordinary),
        eta2_interval=eta2_interval(*ordinary, confidence),
        pairs=_pairs(values, confidence),
    )


def _pairs(
    values: Mapping[str, NDArray[np.float64]], confidence: float
) -> tuple[GroupDifference, ...]:
    from scipy import stats

    pairs = list(combinations(values, 2))
    tests = [stats.ttest_ind(values[a], values[b], equal_var=False) for a, b in pairs]
    found = []
    for (a, b), test, p_holm in zip(
        pairs, tests, holm([float(test.pvalue) for test in tests]), strict=True
    ):
        bounds = test.confidence_interval(confidence)
        g, g_interval = hedges_g(values[a], values[b], confidence)
        found.append(
            GroupDifference(
                first=a,
                second=b,
                difference=float(values[a].mean() - values[b].mean()),
                interval=ConfidenceInterval(float(bounds.low), float(bounds.high), confidence),
                t=float(test.statistic),
                df=float(test.df),
                p=float(test.pvalue),
                p_holm=p_holm,
                hedges_g=g,
                hedges_g_interval=g_interval,
            )
        )
    return tuple(found)
