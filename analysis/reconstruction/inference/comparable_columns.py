"""Check whether columns from the same participants can be compared."""

from __future__ import annotations

from collections.abc import Sequence
from math import log
from typing import TYPE_CHECKING

import numpy as np

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reconstruction.counts.state_table import Array
    from slipscale.analysis.reconstruction.data_sets.solutions import Solutions

# Significance level of the tests.
LEVEL = 0.05


def require_comparable(columns: Sequence[Solutions]) -> None:
    """Check that there are two or more columns, all with the same n and the same scale.

    Raises
    ------
    UserError
        If there are fewer than two columns, or if the columns differ in n or scale.
    """
    if len(columns) < 2:  # noqa: PLR2004 - one column has nothing to be compared with
        raise UserError("conclusions compare columns: expected two or more columns")
    first = columns[0].column
    for other in (solutions.column for solutions in columns[1:]):
        if (other.n, other.scale) != (first.n, first.scale):
            raise UserError(
                "columns '{first}' and '{other}' differ in n or scale; conclusions across "
                "columns require the same participants and the same scale",
                first=first.label,
                other=other.label,
            )


def labels(columns: Sequence[Solutions]) -> list[str]:
    """Return the labels of the columns."""
    return [solutions.column.label for solutions in columns]


def log_amplitudes(columns: Sequence[Solutions]) -> dict[int, float]:
    """Return the logarithms of the published amplitudes, keyed by column index."""
    return {
        place: log(solutions.column.amplitude_um_pp)
        for place, solutions in enumerate(columns)
        if solutions.column.amplitude_um_pp
    }


def values_of(solutions: Solutions, steps: Array) -> Array:
    """Convert numbers of steps above the scale minimum to ratings."""
    scale = solutions.column.scale
    values: Array = float(scale.minimum) + float(scale.step) * np.asarray(steps)
    return values
