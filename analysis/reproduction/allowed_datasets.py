"""Count the data sets consistent with Table III, for `slipscale reproduce`."""

from __future__ import annotations

from dataclasses import dataclass

from slipscale.analysis.published import biet2007
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS
from slipscale.analysis.reconstruction.table.table_files import read

AMPLITUDES_UM_PP = tuple(biet2007.BY_AMPLITUDE)


@dataclass(frozen=True)
class Count:
    """Number of data sets consistent with a column under one SD convention.

    ``ordered`` distinguishes participants; ``multisets`` does not.
    """

    amplitude_um_pp: float
    sd_convention: str
    multisets: int
    ordered: int


def columns() -> list[Solutions]:
    """Return the solutions for the four columns, in the order of `AMPLITUDES_UM_PP`."""
    return [Solutions(column) for column in read(biet2007.TABLE3_FILE).columns]


def counts() -> tuple[Count, ...]:
    """Return the number of data sets per column and SD convention."""
    return tuple(
        Count(amplitude, convention, other.multisets, other.ordered)
        for amplitude, solutions in zip(AMPLITUDES_UM_PP, columns(), strict=True)
        for convention in CONVENTIONS
        for other in [solutions.under(convention, solutions.column.rounding)]
    )
