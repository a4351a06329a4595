"""A search that tries to break what is said of every data set that Table III allows.

Data sets of both conventions of the SD are drawn, the columns are arranged as unfavourably as is
known, and columns are exchanged for others as long as that helps. What it reaches must lie within
the recorded bounds, and near enough to them to show that the search is in earnest.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.inference.pairing import least_alike, most_alike
from slipscale.analysis.reconstruction.table.published_table import CONVENTIONS
from slipscale.analysis.reproduction.allowed_datasets import AMPLITUDES_UM_PP, columns
from slipscale.analysis.reproduction.comparison import recorded_values
from slipscale.analysis.statistics.repeated_measures.batched import paired_t, repeated_measures_f

DRAWN = 300
ROUNDS = 4


@pytest.fixture(scope="module", params=CONVENTIONS)
def drawn(request):
    """Data sets of each column, shape (columns, drawn, participants)."""
    generator = np.random.default_rng(17)
    chosen = [solutions.under(request.param, "nearest") for solutions in columns()]
    return np.stack([Sampler(one).draw(DRAWN, generator) for one in chosen]).astype(float)


@pytest.fixture(scope="module")
def bounds():
    return recorded_values()


@pytest.mark.parametrize("pair", list(combinations(range(4), 2)), ids=str)
def test_no_pair_of_columns_leaves_the_ranges_of_t_and_of_signs(drawn, bounds, pair):
    x, y = drawn[pair[0]], drawn[pair[1]]
    every = np.stack([np.repeat(x, DRAWN, axis=0), np.tile(y, (DRAWN, 1))], axis=2)
    arranged = np.concatenate([most_alike(every), least_alike(every)])
    names = [f"{AMPLITUDES_UM_PP[place]:g}um" for place in pair]
    low, high = (bounds[f"conclusions.t.{'.'.join(names)}.{end}"] for end in ("lowest", "highest"))
    t = paired_t(arranged)
    # The search may come upon the very table that attains a bound.
    assert low * (1 - 1e-9) <= t.min() <= t.max() <= high * (1 + 1e-9)
    assert t.min() < 1.1 * low
    above = (arranged[:, :, 1] > arranged[:, :, 0]).sum(axis=1)
    assert above.min() >= bounds[f"conclusions.sign.{'.'.join(names)}.lowest"]
    assert above.max() <= bounds[f"conclusions.sign.{'.'.join(names)}.highest"]


def test_no_table_falls_below_the_least_f(drawn, bounds):
    best = drawn[:, 0]
    for place in list(range(len(drawn))) * ROUNDS:
        tries = np.repeat(best[None], DRAWN, axis=0)
        tries[:, place] = drawn[place]
        arranged = least_alike(np.swapaxes(tries, 1, 2))
        best = tries[repeated_measures_f(arranged).argmin()]
    reached = repeated_measures_f(least_alike(best.T[None]))[0]
    least = bounds["conclusions.rm_f.lowest"]
    assert least * (1 - 1e-9) <= reached < 1.1 * least
