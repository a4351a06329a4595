"""Holm's correction of a family of p."""

from __future__ import annotations

import numpy as np


def holm(ps: list[float]) -> list[float]:
    """Return Holm's corrected p; what is NaN stays NaN and is no member of the family."""
    from statsmodels.stats.multitest import multipletests  # noqa: PLC0415 - a second's import

    raw = np.array(ps)
    usable = np.isfinite(raw)
    adjusted = np.full(len(raw), np.nan)
    if usable.any():
        adjusted[usable] = multipletests(raw[usable], method="holm")[1]
    return [float(p) for p in adjusted]
