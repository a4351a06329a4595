"""Bounds against every pair of data sets and every pairing; what Table III decides."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from scipy.stats import ttest_rel

from analysis.reconstruction.bounds import larger, log_mean, paired_t, repeated_measures_f, slope
from analysis.reconstruction.reproduce_section import columns, table3_dataset
from analysis.reconstruction.sampling import Sampler
from analysis.reconstruction.solutions import Solutions


@pytest.fixture(scope="module")
def small(column):
    facts = [("2.25", "1.7"), ("3.50", "1.3")]
    return [Sampler(Solutions(column(4, *f, maximum=6))).listed for f in facts]


def every_pairing(x, y):
    return [(a, np.array(b)) for a in x for row in y for b in permutations(row)]


def test_the_sign_count_is_bounded_sharply_over_every_pairing(small):
    counts = [int((b > a).sum()) for a, b in every_pairing(*small)]
    found = larger(*small)
    assert (found.low, found.high) == (min(counts), max(counts))


def test_paired_t_is_bounded_sharply_over_every_pairing(small):
    ts = [ttest_rel(b, a).statistic for a, b in every_pairing(*small) if np.ptp(b - a)]
    found = paired_t(*small)
    assert found.low == pytest.approx(min(ts))
    assert found.high == pytest.approx(max(ts))


def test_too_many_pairs_to_search_are_bounded_from_outside(small, monkeypatch):
    sharp = paired_t(*small)
    monkeypatch.setattr("analysis.reconstruction.bounds.SEARCHED", 0)
    loose = paired_t(*small)
    assert not loose.sharp
    assert loose.low <= sharp.low <= sharp.high <= loose.high


@pytest.fixture(scope="module")
def listed():
    return [Sampler(column).listed for column in columns()]


def test_everybody_rated_1_2_um_above_0_5_um(listed):
    found = larger(listed[1], listed[2])
    assert (found.low, found.high, found.sharp) == (12, 12, True)


def test_at_least_ten_rated_1_2_um_above_0_um(listed):
    assert larger(listed[0], listed[2]).low == 10


def test_the_repeated_measures_f_is_at_least_88_36(listed):
    assert repeated_measures_f(listed) == pytest.approx(88.36, abs=0.005)


def test_the_exponent_of_the_geometric_means_lies_between_0_994_and_1_007(listed):
    found = slope([log_mean(c) for c in listed[1:]], list(np.log([0.5, 1.2, 2.3])))
    assert (round(found.low, 3), round(found.high, 3)) == (0.994, 1.007)


def test_a_drawn_data_set_has_table_3s_means_and_repeats_with_its_seed():
    data = table3_dataset(4)
    assert data == table3_dataset(4) != table3_dataset(5)
    assert [round(float(np.mean(x)), 2) for x in data.values()] == [12.75, 19.58, 56.25, 81.33]
    assert [round(float(np.std(x, ddof=1)), 2) for x in data.values()] == [12.75, 8.11, 8.82, 10.76]
