"""Compare all pairs of amplitudes by paired t tests and Wilcoxon tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from math import exp, nan
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import bounds, renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.effect_sizes import d_z_interval
from slipscale.analysis.statistics.equivalence import Equivalence, bayes_factor, equivalence
from slipscale.analysis.statistics.holm import holm
from slipscale.analysis.statistics.mean_over_participants import (
    MeanOverParticipants,
    mean_over_participants,
)
from slipscale.analysis.statistics.not_computed import NotComputed

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import NDArray

    from slipscale.analysis.preprocessing.log_transform import Prepared
    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval

#: Largest numbers of differences for which Wilcoxon tests are exact, without ties and with ties.
EXACT_AT_MOST, EXACT_WITH_TIES = 50, 13
#: Differences are divided by the largest and rounded to this number of decimals to find ties.
TIED_DECIMALS = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class PairedT:
    """The result of a paired t test on mean log estimates.

    Parameters
    ----------
    ratio : float
        Geometric mean at the larger amplitude, divided by geometric mean at the smaller amplitude.
    ratio_interval : ConfidenceInterval
        t-based interval for the ratio, computed on logarithms.
    t, df, p, p_holm : float, int, float, float
        Two-sided t test, with ``p_holm`` Holm-corrected across all pairs.
    d_z : float
        Mean difference divided by the standard deviation of the differences.
    d_z_interval : ConfidenceInterval or None
        Exact interval for d_z, or None if it is not defined.
    equivalence : Equivalence
        Test of whether the two amplitudes are equivalent.
    equivalence_p_holm : float
        p-value of the equivalence test, Holm-corrected across all pairs.
    bayes_factor : float
        Bayes factor in favour of a difference, which is infinite if it overflows.
    """

    ratio: float
    ratio_interval: ConfidenceInterval
    t: float
    df: int
    p: float
    p_holm: float
    d_z: float
    d_z_interval: ConfidenceInterval | None
    equivalence: Equivalence
    equivalence_p_holm: float
    bayes_factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SignedRank:
    """The result of Wilcoxon's signed-rank test on estimates.

    ``up`` and ``down`` are the numbers of participants whose estimate increased or decreased. ``p``
    and ``p_holm`` are two-sided. Both p-values are NaN if no estimate changed, or if fewer than
    three participants have both estimates.
    """

    up: int
    down: int
    p: float
    p_holm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PairComparison:
    """Comparison of two amplitudes.

    Parameters
    ----------
    from_level, to_level : float
        The smaller and the larger amplitude in µm peak to peak.
    n, n_logs : int
        Numbers of participants with an estimate (``n``) and with a mean logarithm (``n_logs``) at
        both amplitudes. A participant without a value at one amplitude is still included in the
        other pairs.
    logs, ranks
        Results of the t test (``n_logs`` participants) and of the Wilcoxon test (``n``
        participants).
    """

    from_level: float
    to_level: float
    n: int
    n_logs: int
    logs: PairedT | NotComputed
    ranks: SignedRank

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        keys: dict[str, object] = {
            "from_level": self.from_level,
            "to_level": self.to_level,
            "n": self.n,
            "n_logs": self.n_logs,
        }
        equal: dict[str, object] = {}
        logs = self.logs
        if isinstance(logs, NotComputed):
            keys |= {"reason": logs.reason, "p": None}
            p_holm = None
        else:
            left_out = dict.fromkeys(
                ("p_holm", "equivalence", "equivalence_p_holm", "bayes_factor"), ""
            )
            keys |= renamed(logs, ratio_interval="ratio_ci", d_z_interval="d_z_ci", **left_out)
            keys["d_z_ci"] = bounds(logs.d_z_interval)
            equal |= {
                "equivalence_ratio": logs.equivalence.bound,
                "equivalence_ci": logs.equivalence.interval,
                "equivalence_p": logs.equivalence.p,
                "equivalence_p_holm": logs.equivalence_p_holm,
                "bayes_factor_10": logs.bayes_factor,
            }
            p_holm = logs.p_holm
        return keys | {
            "p_wilcoxon": self.ranks.p,
            "up": self.ranks.up,
            "down": self.ranks.down,
            "p_holm": p_holm,
            "p_wilcoxon_holm": self.ranks.p_holm,
            **equal,
        }


def pairwise(data: Prepared) -> tuple[PairComparison, ...] | NotComputed:
    """Compare all pairs of amplitudes by paired t and Wilcoxon tests, with Holm's correction.

    Each pair includes all participants with values at both amplitudes. Participants without a
    logarithm at an amplitude, because all their estimates at this amplitude are zero, are excluded
    from its t tests but not from its rank tests.
    """
    cells = data.cells
    if cells.shape[1] < 2:  # noqa: PLR2004
        return NotComputed(few(data.quantity.levels, cells.shape[1], 2))
    if len(cells) < FEWEST:
        return NotComputed(few("participants", len(cells)))
    pairs = list(combinations(cells.columns, 2))
    differences, steps = (
        [_present(table[high] - table[low]) for low, high in pairs]
        for table in (data.logs.reindex(columns=cells.columns), cells)
    )
    raw = [signed_rank_p(each) if len(each) >= FEWEST else nan for each in steps]
    return tuple(
        PairComparison(
            from_level=float(low),
            to_level=float(high),
            n=len(step),
            n_logs=len(difference),
            logs=logs,
            ranks=SignedRank(
                up=int((step > 0).sum()), down=int((step < 0).sum()), p=p, p_holm=rank_p
            ),
        )
        for (low, high), difference, logs, step, p, rank_p in zip(
            pairs, differences, _paired_t(data, differences), steps, raw, holm(raw), strict=True
        )
    )


def _present(differences: pd.Series[float]) -> NDArray[np.float64]:
    return np.asarray(differences.dropna().to_numpy(float), np.float64)


def _mean(data: Prepared, differences: NDArray[np.float64]) -> MeanOverParticipants | NotComputed:
    if data.refused:
        return NotComputed(data.zero_sentence)
    if len(differences) < FEWEST:
        return NotComputed(
            few(
                f"participants with an estimate above zero at both {data.quantity.levels}",
                len(differences),
            )
        )
    found = mean_over_participants(differences, data.choices.confidence)
    if isinstance(found, NotComputed):
        ratio = exp(float(differences.mean()))
        return NotComputed(f"the ratio is {ratio:.4g} for all participants, so no test is possible")
    return found


def _paired_t(
    data: Prepared, differences: list[NDArray[np.float64]]
) -> list[PairedT | NotComputed]:
    means = [_mean(data, each) for each in differences]
    tested = [mean for mean in means if mean]
    same = [equivalence(mean, data.choices.equivalence_ratio) for mean in tested]
    found = (
        PairedT(
            ratio=float(np.exp(mean.mean)),
            ratio_interval=replace(
                mean.interval, low=exp(mean.interval.low), high=exp(mean.interval.high)
            ),
            t=mean.t,
            df=mean.df,
            p=mean.p,
            p_holm=p_holm,
            d_z=mean.mean / mean.sd,
            d_z_interval=d_z_interval(mean.t, mean.df + 1, mean.interval.confidence),
            equivalence=within,
            equivalence_p_holm=within_p,
            bayes_factor=bayes_factor(mean.t, mean.df + 1),
        )
        for mean, p_holm, within, within_p in zip(
            tested,
            holm([mean.p for mean in tested]),
            same,
            holm([each.p for each in same]),
            strict=True,
        )
    )
    return [mean if isinstance(mean, NotComputed) else next(found) for mean in means]


def signed_rank_p(differences: NDArray[np.float64]) -> float:
    """Return the two-sided Wilcoxon signed-rank p-value, exact for small samples with ties.

    With ties in small samples, SciPy permutes in a Python loop and takes about a second per pair.
    This function permutes precomputed ranks, which is a thousand times faster.
    """
    from scipy import stats

    steps = differences[np.isfinite(differences)]
    largest = np.abs(steps).max(initial=0.0)
    if not largest:
        return float("nan")
    # Equal means can differ in the last bits, by the order of addition; they are still tied.
    steps = np.round(steps / largest, TIED_DECIMALS)
    steps = steps[steps != 0]
    sizes = np.abs(steps)
    tied = len(np.unique(sizes)) < len(sizes)
    if tied and len(steps) <= EXACT_WITH_TIES:
        found = stats.permutation_test(
            (np.sign(steps) * stats.rankdata(sizes),),
            lambda signed, axis: signed.sum(axis=axis),
            permutation_type="samples",
            vectorized=True,
            n_resamples=np.inf,
        )
        return float(found.pvalue)
    method = "asymptotic" if tied or len(steps) > EXACT_AT_MOST else "exact"
    return float(stats.wilcoxon(steps, method=method).pvalue)
