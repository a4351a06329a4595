"""Every two amplitudes compared: paired t on logarithms, Wilcoxon's test on estimates."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from analysis.statistics.effect_sizes import d_z_interval
from analysis.statistics.omnibus import Result, log_table, mean_with_interval, reason

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from analysis.preprocessing.log_transform import Prepared

#: Wilcoxon's test is exact up to so many differences without and with ties.
EXACT_AT_MOST, EXACT_WITH_TIES = 50, 13


def pairwise(data: Prepared) -> list[Result] | Result:
    """Compare every two amplitudes: paired t on logarithms and Wilcoxon on estimates, Holm's p.

    Effect sizes: the ratio of geometric means, and d_z, the mean difference over the standard
    deviation of the differences.
    """
    from statsmodels.stats.multitest import multipletests  # noqa: PLC0415

    table, why = log_table(data)
    if why:
        return reason(why)
    ranks = data.whole
    rows: list[Result] = []
    for low, high in combinations(table.columns, 2):
        difference = (table[high] - table[low]).to_numpy(float)
        row: Result = {"from_um_pp": float(low), "to_um_pp": float(high), "n": len(difference)}
        found = mean_with_interval(difference, data.choices.confidence)
        if "reason" in found:
            row |= found | {"p": float("nan")}
        else:
            d_z = found["mean"] / found["sd"]
            row |= {
                "ratio": float(np.exp(found["mean"])),
                "ratio_ci": [float(np.exp(bound)) for bound in found["ci"]],
                "t": found["t"],
                "df": found["df"],
                "p": found["p"],
                "d_z": d_z,
                "d_z_ci": d_z_interval(found["t"], len(difference), data.choices.confidence),
            }
        steps = (ranks[high] - ranks[low]).to_numpy(float)
        row["p_wilcoxon"] = signed_rank_p(steps)
        row["up"], row["down"] = int((steps > 0).sum()), int((steps < 0).sum())
        rows.append(row)
    for name in ("p", "p_wilcoxon"):
        raw = np.array([row[name] for row in rows])
        usable = np.isfinite(raw)
        adjusted = np.full(len(raw), np.nan)
        if usable.any():
            adjusted[usable] = multipletests(raw[usable], method="holm")[1]
        for row, value in zip(rows, adjusted, strict=True):
            row[f"{name}_holm"] = float(value)
    return rows


def signed_rank_p(differences: NDArray[np.float64]) -> float:
    """Return the two-sided p of Wilcoxon's signed-rank test, exact up to a dozen ties and all.

    SciPy's own choice for ties in small samples permutes in a Python loop, a second a pair; the
    same permutation test on ranks taken once is a thousand times faster.
    """
    from scipy import stats  # noqa: PLC0415

    steps = differences[np.isfinite(differences) & (differences != 0)]
    if not len(steps):
        return float("nan")
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
