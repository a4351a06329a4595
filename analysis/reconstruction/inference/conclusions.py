"""Determine which conclusions hold in every data set consistent with a table.

A conclusion consists of a question, the range of the answers across all data sets and pairings, and
whether the answer is always the same.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from slipscale.analysis.reconstruction.counts.state_table import Array
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference.bounds import (
    Range,
    Table,
    larger,
    log_mean,
    of_rows,
    slope,
)
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.comparable_columns import (
    LEVEL,
    labels,
    log_amplitudes,
    require_comparable,
    values_of,
)
from slipscale.analysis.reconstruction.inference.extreme_t import COMPARED, paired_t, t_of_moments
from slipscale.analysis.reconstruction.inference.repeated_measures_f import (
    attained_f,
    greatest_f,
    least_f,
)

# One row of ratings per column, with the same order of participants.
Ratings = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Conclusion:
    """The range of answers to one question over all possible data sets.

    Parameters
    ----------
    name : str
        Machine-readable name, such as ``sign.0.5 um.1.2 um``.
    question : str
    low, high : float
        Range of the statistic over all data sets and all pairings.
    p_low, p_high : float or None
        Range of the p-value, or None if there is no test.
    decided : bool
        Whether all data sets and pairings give the same answer.
    sharp : bool
        Whether `low` and `high` are both known to occur in a data set.
    labels : tuple of str
        Labels of the columns that the question is about.
    at_low, at_high : tuple of tuple of float
        Tables of ratings in which the statistic is `low` and `high`, with one row per column and
        the same order of participants in all rows. Empty if no table is known.
    """

    name: str
    question: str
    low: float
    high: float
    p_low: float | None
    p_high: float | None
    decided: bool
    sharp: bool
    labels: tuple[str, ...] = ()
    at_low: Ratings = ()
    at_high: Ratings = ()


# Computing time per pair of data sets when searching for the extreme paired t (measured on Table
# III).
SECONDS_A_PAIR = 0.6e-9


def seconds_to_conclude(sizes: Sequence[int]) -> float:
    """Estimate the computing time in seconds from the number of data sets of each column."""
    compared = sum(min(a * b, COMPARED) for a, b in combinations(sizes, 2))
    return 4.0 + SECONDS_A_PAIR * compared


def conclusions(
    columns: list[Sampler], tell: Callable[[str], None] = lambda _: None
) -> list[Conclusion]:
    """Return all conclusions about the columns, over all data sets and pairings.

    Parameters
    ----------
    columns : list of Sampler
        Two or more columns from the same participants.
    tell : callable
        Function that is called with a description of each step.

    Raises
    ------
    UserError
        If the columns cannot be compared, or have too many data sets to list.
    """
    require_comparable([column.solutions for column in columns])
    found = pairs(columns, tell)
    tell("the least F")
    return found + together(columns)


def pairs(columns: list[Sampler], tell: Callable[[str], None] = lambda _: None) -> list[Conclusion]:
    """Return the conclusions from the sign test and the paired t test for each pair of columns."""
    found = []
    every = list(combinations(columns, 2))
    for place, (a, b) in enumerate(every, start=1):
        one, other = labels([a.solutions, b.solutions])
        tell(f"comparing {other} with {one}, pair {place} of {len(every)}")
        for test, bound in ((signs, larger), (t_test, paired_t)):
            found.append(test([a.solutions, b.solutions], bound(a.listed, b.listed)))
    return found


def signs(columns: Sequence[Solutions], count: Range) -> Conclusion:
    """Return the conclusion from the sign test, given the range of the number of higher ratings."""
    from scipy.stats import binomtest

    n, (one, other) = columns[0].column.n, labels(columns)
    ps = [float(binomtest(int(k), n).pvalue) for k in range(int(count.low), int(count.high) + 1)]
    words = (
        f"participants (of {n}) who rated {other} above {one} "
        "(sign test; ties do not count as above)"
    )
    return _concluded("sign", words, columns, count, (min(ps), max(ps)))


def t_test(columns: Sequence[Solutions], t: Range) -> Conclusion:
    """Return the conclusion from the paired t test, given the range of t."""
    from scipy.stats import t as student

    degrees, (one, other) = columns[0].column.n - 1, labels(columns)
    # The value of the range that is closest to 0 is an end of the range, or 0 itself.
    nearest = 0.0 if t.low < 0 < t.high else min(abs(t.low), abs(t.high))
    ps = [float(2 * student.sf(edge, degrees)) for edge in (max(abs(t.low), abs(t.high)), nearest)]
    words = f"paired t({degrees}) of {other} minus {one}"
    return _concluded("t", words, columns, t, (ps[0], ps[1]))


def f_test(columns: Sequence[Solutions], f: Range) -> Conclusion:
    """Return the conclusion from the repeated-measures F test, given the range of F."""
    from scipy.stats import f as fisher

    k, n = len(columns), columns[0].column.n
    degrees = (k - 1, (k - 1) * (n - 1))
    ps = [float(fisher.sf(value, *degrees)) for value in (f.high, f.low)]
    words = f"repeated-measures F{degrees}"
    return replace(_concluded("rm_f", words, columns, f, (ps[0], ps[1])), name="rm_f")


def _concluded(
    name: str,
    words: str,
    columns: Sequence[Solutions],
    found: Range,
    p: tuple[float, float] | None,
) -> Conclusion:
    ps = p or (None, None)
    return Conclusion(
        ".".join([name, *labels(columns)]),
        words,
        found.low,
        found.high,
        ps[0],
        ps[1],
        decided=p is None or (p[0] < LEVEL) == (p[1] < LEVEL),
        sharp=found.sharp,
        labels=tuple(labels(columns)),
        at_low=_ratings(columns, found.at_low),
        at_high=_ratings(columns, found.at_high),
    )


def _ratings(columns: Sequence[Solutions], table: Table) -> Ratings:
    return tuple(
        tuple(float(v) for v in values_of(column, np.array(row)))
        for column, row in zip(columns, table, strict=False)
    )


def together(columns: list[Sampler]) -> list[Conclusion]:
    """Return conclusions about repeated-measures F and, if amplitudes are stated, exponents."""
    found, solutions = attained_f(columns), [column.solutions for column in columns]
    return [
        *([f_test(solutions, found)] if found else []),
        *_exponents(columns, [column.listed for column in columns]),
    ]


def of_moments(columns: Sequence[Solutions]) -> list[Conclusion]:
    """Return conclusions about t and F, using only sums and sums of squares.

    Raises
    ------
    UserError
        If the columns cannot be compared.
    """
    require_comparable(columns)
    n = columns[0].column.n
    moments = [column.attained[0] for column in columns]
    found = [
        t_test([columns[i], columns[j]], t_of_moments(moments[i], moments[j], n))
        for i, j in combinations(range(len(columns)), 2)
    ]
    least = least_f(moments, n)
    if least is None:
        return found
    high, _ = greatest_f([ColumnRows(column, sums_first=True) for column in columns])
    return [*found, f_test(columns, Range(least, high))]


def _exponents(columns: list[Sampler], listed: list[Array]) -> list[Conclusion]:
    """Return conclusions about the exponents of those kinds of group means that cannot be zero."""
    logs = log_amplitudes([column.solutions for column in columns])
    if len(logs) < 2:  # noqa: PLR2004 - a slope needs two points
        return []
    chosen = [values_of(columns[i].solutions, listed[i]) for i in logs]
    means = [c.mean(axis=1) for c in chosen]
    ranges = {}
    if all(mean.min() > 0 for mean in means):
        ranges["arithmetic"] = [
            of_rows(np.log(mean), listed[i]) for i, mean in zip(logs, means, strict=True)
        ]
    # A rating of zero has no logarithm.
    if all(c.min() > 0 for c in chosen):
        ranges["geometric"] = [
            of_rows(log_mean(c), listed[i]) for i, c in zip(logs, chosen, strict=True)
        ]
    concerned = [columns[i].solutions for i in logs]
    return [
        replace(
            _concluded(
                "exponent", f"exponent of the {kind} means", concerned,
                slope(parts, list(logs.values())), None,
            ),
            name=f"exponent.{kind}",
        )
        for kind, parts in ranges.items()
    ]  # fmt: skip
