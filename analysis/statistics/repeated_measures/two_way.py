"""Perform a two-way within-participant analysis of variance, with the same results as R's afex."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.effect_sizes import eta2_interval, eta2_of
from slipscale.analysis.statistics.not_computed import NotComputed


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """The test of an effect in a repeated-measures analysis of variance.

    Parameters
    ----------
    F, df1, df2, p : float
        F test. Degrees of freedom are Greenhouse-Geisser-corrected, except for differences between
        groups of participants.
    eta2_partial, eta2_partial_interval
        Partial eta squared, and its interval from the non-central F distribution (None if not
        defined).
    """

    F: float
    df1: float
    df2: float
    p: float
    eta2_partial: float
    eta2_partial_interval: ConfidenceInterval | None

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, eta2_partial_interval="eta2_partial_ci")


def effect(f: float, df1: float, df2: float, epsilon: float, confidence: float) -> Effect:
    """Return the test of an effect, given F, the uncorrected degrees of freedom and epsilon."""
    from scipy import stats

    df1, df2 = float(df1 * epsilon), float(df2 * epsilon)
    return Effect(
        F=float(f),
        df1=df1,
        df2=df2,
        p=float(stats.f.sf(f, df1, df2)),
        eta2_partial=eta2_of(f, df1, df2),
        eta2_partial_interval=eta2_interval(f, df1, df2, confidence),
    )


def two_way(
    whole: pd.DataFrame, confidence: float, cells: str
) -> tuple[Effect, Effect, Effect] | NotComputed:
    """Test two within-participant factors, with the Greenhouse-Geisser correction.

    The test is computed by pingouin, whose sums of squares and epsilons agree with R if no value is
    missing.

    Parameters
    ----------
    whole : DataFrame, shape (participants, first x second)
        Values to test, such as mean log estimates, of participants who have a value in every
        combination of conditions. The columns have a two-level index.
    confidence : float
        Confidence level of the intervals for effect sizes.
    cells : str
        Description of the required values, which is used in the message, such as "every amplitude
        in every session".

    Returns
    -------
    first, second, interaction : Effect
    """
    complete = len(whole) if len(whole.columns) else 0
    if complete < FEWEST:
        return NotComputed(few(f"participants with {cells}", complete))
    own = whole - whole.mean()
    own = own.sub(own.mean(axis=1), axis=0)
    one, other = (own.T.groupby(level=place).transform("mean").T for place in (0, 1))
    # Each effect is tested against its own differences between participants.
    parts = (one, other, own - one - other)
    if min(float(np.abs(each.to_numpy(float)).max()) for each in parts) <= TINY:
        return NotComputed(
            "no variance remains after removing the means of participants and conditions"
        )
    import pingouin

    n = len(whole)
    long = pd.DataFrame(
        {
            "who": np.repeat(np.arange(n), whole.shape[1]),
            "first": np.tile(whole.columns.get_level_values(0).to_numpy(), n),
            "second": np.tile(whole.columns.get_level_values(1).to_numpy(), n),
            "value": whole.to_numpy(float).ravel(),
        }
    )
    with warnings.catch_warnings():
        # With pandas 3, pingouin's in-place use of dropna causes a warning; others are not
        # suppressed.
        warnings.filterwarnings("ignore", category=pd.errors.Pandas4Warning)
        found = pingouin.rm_anova(
            data=long,
            dv="value",
            within=["first", "second"],
            subject="who",
            detailed=True,
            effsize="np2",
        )
    first, second, interaction = (
        effect(row["F"], row["ddof1"], row["ddof2"], row["eps"], confidence)
        for _, row in found.iterrows()
    )
    return first, second, interaction
