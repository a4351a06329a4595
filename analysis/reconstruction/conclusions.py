"""What a table lets one conclude: in every data set, or only in some.

Records that carry their own words: what was asked, the range of answers over all data sets and
pairings, and whether the conclusion holds in all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import inf, log
from typing import TYPE_CHECKING

from analysis.reconstruction.bounds import (
    Range,
    larger,
    log_mean,
    paired_t,
    repeated_measures_f,
    slope,
)
from analysis.reconstruction.comparable_columns import (
    LEVEL,
    labels,
    log_amplitudes,
    require_comparable,
    values_of,
)

if TYPE_CHECKING:
    from analysis.reconstruction.sampling import Sampler
    from analysis.reconstruction.state_table import Array


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


def conclusions(columns: list[Sampler]) -> list[Conclusion]:
    """Return everything that can be bounded over all data sets and pairings.

    Raises
    ------
    UserError
        The columns cannot stand side by side, or have too many data sets to list.
    """
    require_comparable([column.solutions for column in columns])
    return pairs(columns) + together(columns)


def pairs(columns: list[Sampler]) -> list[Conclusion]:
    """Return sign test and paired t of every two columns, whatever the pairing."""
    n = columns[0].solutions.column.n
    both = zip(labels([c.solutions for c in columns]), (c.listed for c in columns), strict=True)
    return [
        conclusion
        for (name_x, x), (name_y, y) in combinations(both, 2)
        for conclusion in (
            _sign((name_x, name_y), larger(x, y), n),
            _t((name_x, name_y), paired_t(x, y), n - 1),
        )
    ]


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

    # Within the range t comes closest to 0 at one end, or at 0 itself.
    nearest = 0.0 if t.low < 0 < t.high else min(abs(t.low), abs(t.high))
    ps = [float(2 * student.sf(edge, degrees)) for edge in (max(abs(t.low), abs(t.high)), nearest)]
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


def together(columns: list[Sampler]) -> list[Conclusion]:
    """Return the repeated-measures F's lower bound and, given amplitudes, the exponents."""
    from scipy.stats import f as fisher  # noqa: PLC0415

    listed = [column.listed for column in columns]
    k, n = len(listed), listed[0].shape[1]
    least, degrees = repeated_measures_f(listed), (k - 1, (k - 1) * (n - 1))
    p = float(fisher.sf(least, *degrees))
    return [
        Conclusion(
            "rm_f", f"repeated-measures F{degrees}, at least", least, inf, 0.0, p,
            decided=p < LEVEL, sharp=False,
        ),
        *_exponents(columns, listed),
    ]  # fmt: skip


def _exponents(columns: list[Sampler], listed: list[Array]) -> list[Conclusion]:
    """Return the exponents of the group's means; none where a mean of zero is possible."""
    logs = log_amplitudes([column.solutions for column in columns])
    if len(logs) < 2:  # noqa: PLR2004 - a slope needs two points
        return []
    chosen = [values_of(columns[i].solutions, listed[i]) for i in logs]
    means = [c.mean(axis=1) for c in chosen]
    ranges = {}
    if all(mean.min() > 0 for mean in means):
        ranges["arithmetic"] = [
            Range(log(mean.min()), log(mean.max()), sharp=True) for mean in means
        ]
    # A rating of zero has no logarithm.
    if all(c.min() > 0 for c in chosen):
        ranges["geometric"] = [log_mean(c) for c in chosen]
    found = []
    for kind, parts in ranges.items():
        exponent = slope(parts, list(logs.values()))
        found.append(
            Conclusion(
                f"exponent.{kind}", f"exponent of the {kind} means", exponent.low, exponent.high,
                None, None, decided=True, sharp=exponent.sharp,
            )
        )  # fmt: skip
    return found
