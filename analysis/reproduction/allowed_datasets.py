"""Compute what `slipscale reproduce` reports on data sets consistent with Table III."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from slipscale.analysis.published import biet2007
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS
from slipscale.analysis.reconstruction.table.table_files import read

AMPLITUDES_UM_PP = tuple(biet2007.BY_AMPLITUDE)


@dataclass(frozen=True)
class Count:
    """Number of data sets consistent with a column under one standard-deviation convention."""

    amplitude_um_pp: float
    sd_convention: str
    multisets: int
    ordered: int


def columns() -> list[Solutions]:
    """Return the solutions for the four columns, in the order of `AMPLITUDES_UM_PP`."""
    return [Solutions(column) for column in read(biet2007.TABLE3_FILE).columns]


def counts() -> tuple[Count, ...]:
    """Return the number of data sets per column and convention."""
    return tuple(
        Count(amplitude, convention, other.multisets, other.ordered)
        for amplitude, solutions in zip(AMPLITUDES_UM_PP, columns(), strict=True)
        for convention in CONVENTIONS
        for other in [solutions.under(convention, solutions.column.rounding)]
    )


def table3_dataset(seed: int) -> dict[float, tuple[int, ...]]:
    """Return a data set consistent with Table III: twelve participants, four amplitudes.

    Each column is drawn uniformly from its multisets (sample SD). It is then shuffled
    independently of the others, because the table does not state who gave which rating.
    Correlations between columns are therefore zero on average, unlike those of real participants.

    Parameters
    ----------
    seed : int
        The same seed gives the same data set.

    Returns
    -------
    dict of float to tuple of int
        Amplitude in µm peak to peak -> ratings of participants 1 to 12.
    """
    generator = np.random.default_rng(seed)
    return {
        amplitude: tuple(
            int(v) for v in generator.permutation(Sampler(solutions).draw(1, generator)[0])
        )
        for amplitude, solutions in zip(AMPLITUDES_UM_PP, columns(), strict=True)
    }
