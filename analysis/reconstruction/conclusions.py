"""What Table III lets one conclude: in every data set, or only in some.

Records that carry their own words: what was asked, the range of answers over all data sets and
pairings, and whether the conclusion holds in all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import log
from typing import TYPE_CHECKING

import numpy as np

from analysis.reconstruction.bounds import (
    Range,
    larger,
    log_mean,
    paired_t,
    repeated_measures_f,
    slope,
)

if TYPE_CHECKING:
    from analysis.reconstruction.sampling import Sampler
    from analysis.reconstruction.side import Array
    from analysis.reconstruction.solutions import Solutions

LEVEL = 0.05


@dataclass(frozen=True)
class Conclusion:
    """One question put to every data set.

    Parameters
    ----------
    name : str
        For machines, such as ``sign.0.5 um.1.2 um``.
    question : str
        In words.
    low, high : float
        The statistic's range over all data sets and all pairings.
    p_low, p_high : float or None
        The range of its two-sided p-value; None if it has none.
    decided : bool
        Whether the answer is the same in every data set.
    sharp : bool
        Whether both ends of the range are attained.
    """

    name: str
    question: str
    low: float
    high: float
    p_low: float | None
    p_high: float | None
    decided: bool
    sharp: bool


def pairs(columns: list[Sampler]) -> list[Conclusion]:
    """Return sign test and paired t of every two columns, whatever the pairing."""
    listed = [column.listed for column in columns]
    found = []
    for i, j in combinations(range(len(columns)), 2):
        names = (
            columns[i].solutions.column.label,
            columns[j].solutions.column.label,
        )
        found += [
            _sign(names, larger(listed[i], listed[j]), columns[i].solutions.column.n),
            _t(names, paired_t(listed[i], listed[j]), columns[i].solutions.column.n - 1),
        ]
    return found


def _sign(names: tuple[str, str], count: Range, n: int) -> Conclusion:
    from scipy.stats import binomtest  # noqa: PLC0415 - SciPy takes longer than the counts

    ps = [float(binomtest(int(k), n).pvalue) for k in range(int(count.low), int(count.high) + 1)]
    return Conclusion(
        f"sign.{names[0]}.{names[1]}",
        f"participants of {n} who rated {names[1]} above {names[0]} (sign test, ties against)",
        count.low,
        count.high,
        min(ps),
        max(ps),
        decided=(min(ps) < LEVEL) == (max(ps) < LEVEL),
        sharp=count.sharp,
    )


def _t(names: tuple[str, str], t: Range, degrees: int) -> Conclusion:
    from scipy.stats import t as student  # noqa: PLC0415

    ps = sorted(float(2 * student.sf(abs(edge), degrees)) for edge in (t.low, t.high))
    return Conclusion(
        f"t.{names[0]}.{names[1]}",
        f"paired t({degrees}) of {names[1]} minus {names[0]}",
        t.low,
        t.high,
        ps[0],
        ps[1],
        decided=(ps[0] < LEVEL) == (ps[1] < LEVEL),
        sharp=t.sharp,
    )


def together(columns: list[Sampler], log_amplitude: dict[int, float]) -> list[Conclusion]:
    """Return the repeated-measures F's lower bound and the exponents.

    Parameters
    ----------
    columns : list of Sampler
        With the same n.
    log_amplitude : dict of int to float
        For the columns (by place) that enter the power law: log of the amplitude.
    """
    from scipy.stats import f as fisher  # noqa: PLC0415

    listed = [column.listed for column in columns]
    k, n = len(listed), listed[0].shape[1]
    least, degrees = repeated_measures_f(listed), (k - 1, (k - 1) * (n - 1))
    p = float(fisher.sf(least, *degrees))
    chosen = [values_of(columns[i].solutions, listed[i]) for i in log_amplitude]
    x = list(log_amplitude.values())
    geometric = slope([log_mean(c) for c in chosen], x)
    means = [Range(m, m, sharp=True) for m in (log(float(c[0].mean())) for c in chosen)]
    arithmetic = slope(means, x)
    return [
        Conclusion(
            "rm_f", f"repeated-measures F{degrees}, least", least, float("inf"), 0.0, p,
            decided=p < LEVEL, sharp=False,
        ),
        Conclusion(
            "exponent.arithmetic", "exponent of the arithmetic means",
            arithmetic.low, arithmetic.high, None, None, decided=True, sharp=True,
        ),
        Conclusion(
            "exponent.geometric", "exponent of the geometric means",
            geometric.low, geometric.high, None, None, decided=True, sharp=True,
        ),
    ]  # fmt: skip


def values_of(solutions: Solutions, steps: Array) -> Array:
    """Return ratings from steps above the scale's minimum."""
    scale = solutions.column.scale
    values: Array = float(scale.minimum) + float(scale.step) * np.asarray(steps)
    return values
