"""Bounds against every pair of data sets and every pairing; what Table III decides."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from scipy.stats import ttest_rel

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference.bounds import larger
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.conclusions import (
    conclusions,
    pairs,
    seconds_to_conclude,
    together,
)
from slipscale.analysis.reconstruction.inference.extreme_t import paired_t, t_of_moments
from slipscale.analysis.reconstruction.inference.repeated_measures_f import (
    attained_f,
    greatest_f,
    least_f,
)
from slipscale.analysis.reproduction.allowed_datasets import columns
from slipscale.analysis.statistics.repeated_measures import batched


@pytest.fixture(scope="module")
def small(column):
    facts = [("2.25", "1.7"), ("3.50", "1.3")]
    return [Sampler(Solutions(column(4, *f, maximum=6))).listed for f in facts]


def every_pairing(x, y):
    return [(a, np.array(b)) for a in x for row in y for b in permutations(row)]


def attained(found, statistic):
    """Whether the tables that a range comes with have the values at its ends."""
    return [statistic(*map(np.array, at)) for at in (found.at_low, found.at_high)] == [
        pytest.approx(found.low),
        pytest.approx(found.high),
    ]


def test_the_sign_count_is_bounded_sharply_over_every_pairing(small):
    counts = [int((b > a).sum()) for a, b in every_pairing(*small)]
    for x, y in permutations(small):
        found = larger(x, y)
        assert attained(found, lambda a, b: (b > a).sum())
        assert all(
            sorted(at) in rows.tolist() for at, rows in zip(found.at_low, (x, y), strict=True)
        )
    found = larger(*small)
    assert (found.low, found.high) == (min(counts), max(counts))


def test_paired_t_is_bounded_sharply_over_every_pairing(small):
    ts = [ttest_rel(b, a).statistic for a, b in every_pairing(*small) if np.ptp(b - a)]
    found = paired_t(*small)
    assert found.low == pytest.approx(min(ts))
    assert found.high == pytest.approx(max(ts))


@pytest.mark.parametrize(
    "facts",
    [
        [("2.25", "1.7"), ("3.50", "1.3")],
        [("2.25", "1.7"), ("2.50", "1.7")],
        [("2.2", "1"), ("2.5", "2")],
        [("2.25", "1.7"), ("2.25", "1.7")],
        [("3.0", "0.0"), ("3.0", "0.0")],
        [("3.0", "0.0"), ("4.0", "0.0")],
    ],
)
def test_f_of_two_columns_is_the_square_of_t_over_every_pairing_and_has_its_tables(column, facts):
    """0/0 is 0: without a difference between the sums, no pairing is significant."""
    samplers = [Sampler(Solutions(column(4, *each, maximum=6))) for each in facts]
    squares = []
    for a, b in every_pairing(*(each.listed for each in samplers)):
        steps = (b - a).astype(float)
        spread = steps.std(ddof=1)
        squares.append(
            0.0 if not steps.sum() else np.inf if not spread else (steps.mean() * 2 / spread) ** 2
        )
    found = attained_f(samplers)
    assert (found.low, found.high) == pytest.approx((min(squares), max(squares)))
    assert found.sharp
    tables = np.stack([np.transpose(at) for at in (found.at_low, found.at_high)]).astype(float)
    assert batched.repeated_measures_f(tables) == pytest.approx([found.low, found.high])
    (bound,) = [each for each in together(samplers) if each.name == "rm_f"]
    assert bound.decided == ((min(squares) > 10.128) == (max(squares) > 10.128))  # F(1, 3) at .05


def test_equal_sums_are_never_significant_in_three_columns(column):
    samplers = [Sampler(Solutions(column(4, "2.25", "1.7", maximum=6))) for _ in range(3)]
    (found,) = [each for each in together(samplers) if each.name == "rm_f"]
    assert (found.low, found.high, found.p_low) == (0.0, 0.0, 1.0)


def test_nearest_neighbours_find_what_trying_every_pair_finds(column, monkeypatch):
    facts = [("2.0", "1.7"), ("3", "1.3"), ("1.7", "1.5"), ("2.1", "1.6")]
    lists = [Sampler(Solutions(column(7, *f, maximum=6))).listed for f in facts]
    for x, y in permutations(lists, 2):
        tried = paired_t(x, y)
        with monkeypatch.context() as patch:
            patch.setattr("slipscale.analysis.reconstruction.inference.extreme_t.SEARCHED", 0)
            found = paired_t(x, y)
            assert (found.low, found.high) == (tried.low, tried.high)
        for one in (tried, found):
            assert attained(one, lambda a, b: ttest_rel(b, a).statistic)


def test_too_many_pairs_to_compare_are_bounded_from_outside(small, monkeypatch):
    sharp = paired_t(*small)
    monkeypatch.setattr("slipscale.analysis.reconstruction.inference.extreme_t.COMPARED", 0)
    loose = paired_t(*small)
    assert not loose.sharp
    assert loose.low <= sharp.low <= sharp.high <= loose.high


def test_a_mean_that_leaves_the_sum_open_is_bounded_over_every_sum(column):
    facts = [("2", "1.7"), ("3", "1.3")]
    samplers = [Sampler(Solutions(column(4, *f, maximum=6))) for f in facts]
    x, y = (sampler.listed for sampler in samplers)
    assert len(set(x.sum(axis=1))) > 1
    ts = [ttest_rel(b, a).statistic for a, b in every_pairing(x, y) if np.ptp(b - a)]
    found = paired_t(x, y)
    assert (found.low, found.high) == (pytest.approx(min(ts)), pytest.approx(max(ts)))
    tables = np.stack([np.stack(pair, axis=1) for pair in every_pairing(x, y)])
    smallest = batched.repeated_measures_f(tables.astype(float)).min()
    moments = [tuple({(int(r.sum()), int((r**2).sum())) for r in rows}) for rows in (x, y)]
    assert least_f(moments, 4) <= smallest + 1e-9
    finite = batched.repeated_measures_f(tables.astype(float))
    greatest, table = greatest_f([ColumnRows(one.solutions) for one in samplers])
    assert greatest == pytest.approx(finite[np.isfinite(finite)].max())
    assert batched.repeated_measures_f(np.array(table, float).T[None])[0] == pytest.approx(greatest)
    outer = t_of_moments(moments[0], moments[1], 4)
    assert outer.low <= found.low <= found.high <= outer.high


def test_pairs_asks_for_sign_and_t_of_every_two_columns(column):
    samplers = [
        Sampler(Solutions(column(5, mean, "1.14", maximum=9))) for mean in ("2.40", "3.40", "6.40")
    ]
    found = pairs(samplers)
    assert [c.name.split(".")[0] for c in found] == ["sign", "t"] * 3
    assert [c.decided for c in found if c.name.startswith("t")] == [False, True, True]
    for c in found:
        assert 0 <= c.p_low <= c.p_high <= 1
        assert c.low <= c.high


def test_what_is_compared_is_told(column):
    samplers = [Sampler(Solutions(column(5, mean, "1.14", maximum=9))) for mean in ("2.40", "6.40")]
    told = []
    conclusions(samplers, told.append)
    assert told == ["comparing x with x, pair 1 of 1", "the least F"]


def test_the_time_that_conclusions_take_is_guessed_from_the_lists():
    assert seconds_to_conclude([100, 100]) < 5
    table_3 = seconds_to_conclude([40711, 1336, 83530, 605304])
    assert 30 < table_3 < 90


def kinds(column, lowest, amplitudes):
    samplers = [
        Sampler(Solutions(column(4, mean, "1.29", maximum=9, amplitude_um_pp=amplitude)))
        for mean, amplitude in zip((lowest, "5.50"), amplitudes, strict=True)
    ]
    return [c.name for c in together(samplers)]


def test_exponents_need_two_amplitudes_and_geometric_ones_no_zero(column):
    assert kinds(column, "2.50", (None, None)) == ["rm_f"]
    assert kinds(column, "2.50", (0.0, 2.0)) == ["rm_f"]
    assert kinds(column, "2.50", (1.0, 2.0)) == [
        "rm_f",
        "exponent.arithmetic",
        "exponent.geometric",
    ]
    assert kinds(column, "1.50", (1.0, 2.0)) == ["rm_f", "exponent.arithmetic"]


@pytest.fixture(scope="module")
def of_table_3():
    """Return what Table III's columns conclude together, by name."""
    return {c.name: c for c in together([Sampler(one) for one in columns()])}


def test_exponents_of_table_3s_means_are_those_derived_by_hand_and_prototype(of_table_3):
    found = of_table_3
    assert found["exponent.arithmetic"].low == pytest.approx(0.948, abs=5e-4)
    geometric = found["exponent.geometric"]
    assert (round(geometric.low, 3), round(geometric.high, 3)) == (0.994, 1.007)
    log_um = np.log([0.5, 1.2, 2.3])
    for value, table in ((geometric.low, geometric.at_low), (geometric.high, geometric.at_high)):
        assert np.polyfit(log_um, np.log(table).mean(axis=1), 1)[0] == pytest.approx(value)


def test_the_least_f_is_attained_by_the_table_that_comes_with_it(of_table_3):
    found = of_table_3["rm_f"]
    table = np.array(found.at_low).T[None]
    assert batched.repeated_measures_f(table)[0] == pytest.approx(found.low, rel=1e-12)
    assert found.low < found.high < np.inf
    assert found.low == pytest.approx(88.36272, abs=5e-6)
