"""Fit least-squares lines for many participants at once, even with missing values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.statistics.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Lines:
    """The fitted lines, y = intercept + slope x.

    Parameters
    ----------
    slope, intercept : array, shape (...)
        Slope and intercept of each line. Both are NaN with fewer than two points, or if all x are
        equal.
    points : int array, shape (...)
        Number of points used for each line.
    """

    slope: Array
    intercept: Array
    points: NDArray[np.int64]


def fit_lines(x: Array, y: Array) -> Lines:
    """Fit a least-squares line to each series along the last axis.

    Parameters
    ----------
    x : array, shape (k,)
        Common x values, for example log amplitudes.
    y : array, shape (..., k)
        Values to fit, for example log estimates, with NaN for missing values.
    """
    present = ~np.isnan(y)
    points = present.sum(axis=-1)
    xs, ys = np.where(present, x, 0.0), np.where(present, y, 0.0)
    # If all x values are equal, 0 / 0 gives NaN.
    with np.errstate(invalid="ignore", divide="ignore"):
        x_mean, y_mean = xs.sum(axis=-1) / points, ys.sum(axis=-1) / points
        dx = np.where(present, xs - x_mean[..., None], 0.0)
        dy = np.where(present, ys - y_mean[..., None], 0.0)
        slope = (dx * dy).sum(axis=-1) / (dx**2).sum(axis=-1)
    return Lines(slope=slope, intercept=y_mean - slope * x_mean, points=points)
