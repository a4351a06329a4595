"""Least-squares lines of many participants at once, with missing cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lines:
    """Lines y = intercept + slope x.

    Parameters
    ----------
    slope, intercept : array, shape (...)
        NaN with fewer than two points, or points of one x.
    points : int array, shape (...)
        How many each line rests on.
    """

    slope: Array
    intercept: Array
    points: NDArray[np.int64]


def fit_lines(x: Array, y: Array) -> Lines:
    """Fit a line along the last axis, each by its own least squares.

    Parameters
    ----------
    x : array, shape (k,)
        Such as logarithms of amplitudes.
    y : array, shape (..., k)
        Such as logarithms of estimates; NaN where missing.
    """
    present = ~np.isnan(y)
    points = present.sum(axis=-1)
    xs, ys = np.where(present, x, 0.0), np.where(present, y, 0.0)
    # Without two different x, 0 / 0: NaN.
    with np.errstate(invalid="ignore", divide="ignore"):
        x_mean, y_mean = xs.sum(axis=-1) / points, ys.sum(axis=-1) / points
        dx = np.where(present, xs - x_mean[..., None], 0.0)
        dy = np.where(present, ys - y_mean[..., None], 0.0)
        slope = (dx * dy).sum(axis=-1) / (dx**2).sum(axis=-1)
    return Lines(slope=slope, intercept=y_mean - slope * x_mean, points=points)
