"""Estimate distributions of test statistics over all data sets, for three kinds of pairing.

Each sample contains one data set per column, selected uniformly at random. The ratings of different
columns are paired in three ways: at random, with the smallest statistic (least favourable pairing)
and with the largest statistic (most favourable pairing). The last two pairings are exact if
possible, and otherwise heuristic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.inference.comparable_columns import (
    LEVEL,
    labels,
    log_amplitudes,
    require_comparable,
    values_of,
)
from slipscale.analysis.reconstruction.inference.pairing import (
    at_random,
    least_alike,
    most_alike,
    searched,
)
from slipscale.analysis.statistics.repeated_measures import batched

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
    from slipscale.analysis.reconstruction.inference.pairing import Statistic

    Test = Callable[[Array], Array]
    Arrange = Callable[[Array, np.random.Generator], Array]

PROBABILITIES = (0.0, 0.025, 0.25, 0.5, 0.75, 0.975, 1.0)
SAMPLES = 1000


@dataclass(frozen=True, kw_only=True)
class Distribution:
    """The distribution of one statistic under one kind of pairing.

    Parameters
    ----------
    name : str
        Machine-readable name, such as ``rm_f`` or ``t.0.5 um.1.2 um``.
    question : str
    pairing : {"random", "least favourable", "most favourable"}
        Pairing of the ratings. The least favourable pairing gives the smallest statistic.
    method : {"drawn", "exact", "heuristic"}
        Whether the pairing is random ("drawn"), the most extreme pairing possible ("exact"), or the
        most extreme pairing that a heuristic found ("heuristic").
    quantiles : tuple of (float, float)
        Pairs of probability and quantile. The quantiles for probabilities 0 and 1 are the smallest
        and largest sampled values.
    significant : float or None
        Proportion of samples with p < 0.05, or None if the statistic has no test.
    samples, seed, measure : int, int, str
        Number of samples, random seed and measure, which are needed to reproduce the result.
    """

    name: str
    question: str
    pairing: str
    method: str
    quantiles: tuple[tuple[float, float], ...]
    significant: float | None
    samples: int
    seed: int
    measure: str


@dataclass(frozen=True)
class _Question:
    """A statistic, its test, and functions that pair ratings to minimise or maximise it."""

    name: str
    words: str
    columns: tuple[int, ...]
    statistic: Statistic
    test: Test | None
    least: tuple[str, Arrange]
    most: tuple[str, Arrange]


def distributions(
    columns: list[Sampler], seed: int = 1, samples: int = SAMPLES
) -> list[Distribution]:
    """Estimate the distributions of F, Friedman's chi-square, t and the exponents.

    Parameters
    ----------
    columns : list of Sampler
        Two or more columns from the same participants.
    seed, samples : int
        Random seed, and number of sampled data sets per column.

    Raises
    ------
    UserError
        If the columns cannot be compared.
    """
    require_comparable([column.solutions for column in columns])
    generator = np.random.default_rng(seed)
    tables = np.stack([values_of(c.solutions, c.draw(samples, generator)) for c in columns], axis=2)
    found = []
    for question in _questions(columns):
        chosen = tables[:, :, question.columns]
        for pairing, (method, arrange) in (
            ("least favourable", question.least),
            ("random", ("drawn", at_random)),
            ("most favourable", question.most),
        ):
            arranged = arrange(chosen, generator)
            values = question.statistic(arranged)
            p = None if question.test is None else question.test(arranged)
            found.append(
                Distribution(
                    name=question.name,
                    question=question.words,
                    pairing=pairing,
                    method=method,
                    quantiles=_quantiles(values),
                    significant=None if p is None else float((p < LEVEL).mean()),
                    samples=samples,
                    seed=seed,
                    measure=columns[0].measure,
                )
            )
    return found


def _quantiles(values: Array) -> tuple[tuple[float, float], ...]:
    # Quantiles are not interpolated, because values may be infinite.
    at = np.quantile(values, PROBABILITIES, method="inverted_cdf")
    return tuple(zip(PROBABILITIES, map(float, at), strict=True))


def _questions(columns: list[Sampler]) -> list[_Question]:
    n, k = columns[0].solutions.column.n, len(columns)
    names = labels([column.solutions for column in columns])
    everything = tuple(range(k))
    asked = [
        _Question(
            "rm_f",
            f"repeated-measures F{k - 1, (k - 1) * (n - 1)}, Greenhouse–Geisser-corrected p",
            everything,
            batched.repeated_measures_f,
            _p_of_f,
            ("exact" if k == 2 else "heuristic", _fixed(least_alike)),  # noqa: PLR2004 - a pair
            ("exact", _fixed(most_alike)),
        ),
        _by_search(
            "friedman", f"Friedman's chi-square({k - 1})", everything,
            batched.friedman, _p_of_friedman,
        ),
    ]  # fmt: skip
    for i, j in combinations(everything, 2):
        asked.append(
            _Question(
                f"t.{names[i]}.{names[j]}",
                f"paired t({n - 1}) of {names[j]} minus {names[i]}",
                (i, j),
                batched.paired_t,
                _p_of_t,
                ("exact", partial(_extreme_t, sign=-1)),
                ("exact", partial(_extreme_t, sign=1)),
            )
        )
    logs = log_amplitudes([column.solutions for column in columns])
    if len(logs) > 1:
        x = tuple(logs.values())
        for name, words, function in (
            ("mean", "mean of the participants' exponents", batched.mean_exponent),
            ("sd", "SD of the participants' exponents", batched.sd_of_exponents),
        ):
            asked.append(
                _by_search(
                    f"exponent.{name}", words, tuple(logs), partial(function, log_amplitude=x)
                )
            )
    return asked


def _by_search(
    name: str,
    words: str,
    columns: tuple[int, ...],
    statistic: Statistic,
    test: Test | None = None,
) -> _Question:
    least, most = (
        ("heuristic", partial(_search, statistic=statistic, sign=sign)) for sign in (-1, 1)
    )
    return _Question(name, words, columns, statistic, test, least, most)


def _search(
    tables: Array, generator: np.random.Generator, *, statistic: Statistic, sign: int
) -> Array:
    return searched(tables, statistic, sign, generator)


def _extreme_t(tables: Array, _generator: np.random.Generator, *, sign: int) -> Array:
    """Pair the ratings of two columns so that t is smallest or largest.

    If both columns are sorted in the same order, differences vary least and |t| is largest.
    """
    rises = sign * (tables[:, :, 1] - tables[:, :, 0]).mean(axis=1) >= 0
    return np.where(rises[:, None, None], most_alike(tables), least_alike(tables))


def _fixed(arrange: Callable[[Array], Array]) -> Arrange:
    """Wrap a deterministic pairing function so that it has the signature of a random one."""
    return lambda tables, _generator: arrange(tables)


def _p_of_f(tables: Array) -> Array:
    from scipy.stats import f

    _, n, k = tables.shape
    epsilon = batched.greenhouse_geisser(tables)
    degrees = epsilon * (k - 1), epsilon * (k - 1) * (n - 1)
    return np.asarray(f.sf(batched.repeated_measures_f(tables), *degrees))


def _p_of_friedman(tables: Array) -> Array:
    from scipy.stats import chi2

    return np.asarray(chi2.sf(batched.friedman(tables), tables.shape[2] - 1))


def _p_of_t(tables: Array) -> Array:
    from scipy.stats import t

    return np.asarray(2 * t.sf(np.abs(batched.paired_t(tables)), tables.shape[1] - 1))
