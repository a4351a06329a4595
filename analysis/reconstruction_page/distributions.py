"""Compute distributions of ratings over all data sets consistent with a column."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.reconstruction.answers import worth_marginals
from slipscale.analysis.reconstruction.data_sets.marginals import Marginals, marginals

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions

# Maximum number of bars in a histogram.
BARS = 25
BAND = (0.025, 0.975)


@dataclass(frozen=True, kw_only=True)
class Bands:
    """Summary over all data sets, for each bin or value of the rating scale.

    Parameters
    ----------
    edges : ndarray, shape (places + 1,)
        Edges of the bins, in the unit of the scale.
    mean, low, high, least, most : ndarray, shape (places,)
        Mean, 2.5 % quantile, 97.5 % quantile, smallest value and largest value per bin.
    exact : bool
        Whether the summary is exact, not estimated from samples.
    """

    edges: Array
    mean: Array
    low: Array
    high: Array
    least: Array
    most: Array
    exact: bool


def histogram(solutions: Solutions, samples: Array) -> Bands:
    """Summarise how many ratings each bar of a histogram contains in the sampled data sets.

    `samples` contains one data set per row, in steps above the scale minimum.
    """
    scale = solutions.column.scale
    first, last = int(samples.min()), int(samples.max())
    width = -(-(last - first + 1) // BARS)
    starts = np.arange(first, last + width + 1, width)
    counts = np.stack(
        [((samples >= a) & (samples < b)).sum(axis=1) for a, b in pairwise(starts)], axis=1
    )
    low, high = np.quantile(counts, BAND, axis=0, method="inverted_cdf")
    # Each bar extends half a step beyond the smallest and the largest rating that it contains.
    edges = float(scale.minimum) + float(scale.step) * (starts - 0.5)
    return Bands(
        edges=edges,
        mean=counts.mean(axis=0),
        low=low,
        high=high,
        least=counts.min(axis=0),
        most=counts.max(axis=0),
        exact=False,
    )


def cumulative(solutions: Solutions, samples: Array, measure: str) -> Bands:
    """Summarise the cumulative proportion of ratings.

    If an exact computation would be slow, the summary is estimated from samples.
    """
    if worth_marginals(solutions):
        return _exact_cumulative(solutions, marginals(solutions, measure))
    values = np.arange(int(samples.min()), int(samples.max()) + 1)
    shares = np.stack([(samples <= v).mean(axis=1) for v in values], axis=1)
    low, high = np.quantile(shares, BAND, axis=0, method="inverted_cdf")
    return Bands(
        edges=_edges(solutions, values),
        mean=shares.mean(axis=0),
        low=low,
        high=high,
        least=shares.min(axis=0),
        most=shares.max(axis=0),
        exact=False,
    )


def _exact_cumulative(solutions: Solutions, found: Marginals) -> Bands:
    n = found.n
    first = min(found.order_statistic(1))
    last = max(found.order_statistic(n))
    values = np.arange(first, last + 1)
    # Proportions of data sets with 0 to n ratings up to this step.
    chances = np.array([[c / found.total for c in found.at_most[v]] for v in values])
    running = np.cumsum(chances, axis=1)
    # The tolerance allows for floating-point errors in a sum of 1.
    low, high = ((running >= p - 1e-12).argmax(axis=1) / n for p in BAND)
    possible = chances > 0
    return Bands(
        edges=_edges(solutions, values),
        mean=chances @ np.arange(n + 1) / n,
        low=low,
        high=high,
        least=possible.argmax(axis=1) / n,
        most=(n - possible[:, ::-1].argmax(axis=1)) / n,
        exact=True,
    )


def _edges(solutions: Solutions, values: Array) -> Array:
    scale = solutions.column.scale
    steps = np.append(values, values[-1] + 1)
    found: Array = float(scale.minimum) + float(scale.step) * steps
    return found
