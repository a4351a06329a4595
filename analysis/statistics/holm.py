"""Apply Holm's correction to a family of p-values."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def holm(ps: Sequence[float]) -> list[float]:
    """Return Holm-corrected p-values. NaN remains NaN and is not counted as a test.

    >>> holm([0.01, float("nan"), 0.04, 0.03])
    [0.03, nan, 0.06, 0.06]
    """
    raw = np.array(ps, float)
    return list(map(float, np.where(np.isnan(raw), np.nan, holm_rows(raw[None])[0])))


def holm_rows(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Holm-corrected p-values, treating each row as a family of tests and ignoring NaN."""
    order = np.argsort(p, axis=1)  # NaN last
    left = np.isfinite(p).sum(axis=1)[:, None] - np.arange(p.shape[1])
    steps = np.take_along_axis(p, order, axis=1) * np.maximum(left, 1)
    adjusted = np.empty_like(p)
    np.put_along_axis(adjusted, order, np.fmax.accumulate(steps, axis=1), axis=1)
    return np.minimum(adjusted, 1.0)
