"""Counts against complete enumeration, the published table, and laws."""

from __future__ import annotations

from fractions import Fraction
from math import inf, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from slipscale.analysis.reconstruction.counts import counting
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.table_files import read
from slipscale.faults import UserError


def summaries(n, top):
    """Every (mean, sd) that n ratings from 0 to top can print, to one decimal."""
    step = 10
    return [
        (f"{m / step:.1f}", f"{s / step:.1f}")
        for m in range(top * step + 1)
        for s in range(top * step + 1)
    ]


@pytest.mark.parametrize("convention", ["sample", "population"])
@pytest.mark.parametrize("rule", ["nearest", "half_up", "half_even", "truncated"])
def test_every_small_table_has_the_number_of_data_sets_that_enumeration_finds(
    column, all_multisets, orders, convention, rule
):
    for mean, sd in summaries(4, 4)[::29]:
        c = column(4, mean, sd, maximum=4, sd_convention=convention, rounding=rule)
        found = all_multisets(c)
        solutions = Solutions(c)
        assert solutions.multisets == len(found), (mean, sd)
        assert solutions.ordered == sum(orders(x) for x in found), (mean, sd)
        assert solutions.consistent == (solutions.reason == "")


@st.composite
def columns(draw):
    """Keyword arguments of a column made from ratings, so that it usually has solutions."""
    n = draw(st.integers(2, 7))
    top = draw(st.integers(1, 6))
    x = sorted(draw(st.lists(st.integers(0, top), min_size=n, max_size=n)))
    places = draw(st.integers(0, 2))
    convention = draw(st.sampled_from(["sample", "population"]))
    mean = sum(x) / n
    squares = sum((v - mean) ** 2 for v in x)
    sd = sqrt(squares / (n - 1 if convention == "sample" else n))
    assume(sd <= top)
    facts = {
        "maximum_deviation": max(abs(v - mean) for v in x),
        "observed_minimum": x[0],
        "observed_maximum": x[-1],
        "median": (x[(n - 1) // 2] + x[n // 2]) / 2,
    }
    chosen = draw(st.sets(st.sampled_from(sorted(facts))))
    return {
        "n": n,
        "mean": f"{mean:.{places}f}",
        "sd": f"{sd:.{places}f}",
        "maximum": top,
        "sd_convention": convention,
        **{name: f"{facts[name]:.{places}f}" for name in chosen},
    }


@settings(max_examples=40, deadline=None)
@given(facts=columns())
def test_extremes_medians_and_decimals_leave_what_enumeration_leaves(
    column, all_multisets, orders, facts
):
    try:
        c = column(**facts)
    except UserError:
        assume(False)
    found = all_multisets(c)
    assert Solutions(c).multisets == len(found)
    assert Solutions(c).ordered == sum(orders(x) for x in found)


TABLE_3 = {  # re-derived; agrees with a separate prototype checked by enumeration
    "0 um": (40711, 2962591251840, 69262),
    "0.5 um": (1336, 34964843760, 522),
    "1.2 um": (83530, 8002156919724, 106816),
    "2.3 um": (605304, 76796709905520, 354367),
}


def test_table_3_has_its_known_numbers_of_data_sets():
    for c in read(Path("biet2007_table3")).columns:
        multisets, ordered, population = TABLE_3[c.label]
        solutions = Solutions(c)
        assert (solutions.multisets, solutions.ordered) == (multisets, ordered)
        assert solutions.under("population", "nearest").multisets == population


def test_reflecting_the_scale_keeps_the_count(column):
    assert (
        Solutions(column(9, "30.00", "12.34", maximum=50)).multisets
        == Solutions(column(9, "20.00", "12.34", maximum=50)).multisets
        > 0
    )


def test_shifting_and_stretching_the_scale_keep_the_count(column):
    plain = Solutions(column(9, "20.00", "12.50", maximum=50)).multisets
    shifted = Solutions(column(9, "13.00", "12.50", minimum=-7, maximum=43)).multisets
    halved = Solutions(column(9, "10.000", "6.250", maximum=25, step="1/2")).multisets
    # Halving the unit halves the printed interval; 0.005 / 2 lies within the extra decimal.
    assert plain == shifted
    assert 0 < halved <= plain


def test_counts_beyond_a_machine_word_are_exact(column):
    """n = 20 on 0-12: all sums of squares together give the number of multisets with a sum."""
    n, top, total = 20, 12, 120
    ways = np.zeros((n + 1, total + 1), dtype=object)
    ways[0, 0] = 1
    for value in range(top + 1):
        for k in range(1, n + 1):
            ways[k, value:] += ways[k - 1, : total + 1 - value]
    # An SD of "8" with no decimals at a time covers every sum of squares once.
    counts = [
        Solutions(
            column(n, "6.00", str(sd), maximum=top, rounding="half_up", sd_convention="population")
        )
        for sd in range(7)
    ]
    assert sum(s.multisets for s in counts) == ways[n, total]
    ordered = sum(s.ordered for s in counts)
    one = np.array([1] * (top + 1), dtype=object)
    series = np.array([1], dtype=object)
    for _ in range(n):
        series = np.convolve(series, one)
    assert ordered == series[total] > 2**64


def test_multisets_beyond_a_machine_word_agree_by_two_ways_of_counting(column, monkeypatch):
    """One residue settled by floating point, and residues of 2^64 and a prime joined."""
    c = column(80, "50.00", "6.00")
    settled = Solutions(c).multisets
    assert settled > 2**64
    monkeypatch.setattr(counting.Estimate, "settles", lambda *_: False)
    assert Solutions(c).multisets == settled


def test_an_estimate_settles_a_residue_only_if_it_is_near_enough():
    count = 2**90 + 12345
    near = counting.Estimate(float(count), 2.0**-40)
    assert near.settles(2**64)
    assert near.nearest(count % 2**64, 2**64) == count
    off = counting.Estimate(count * (1 + 2.0**-41), 2.0**-40)
    assert off.nearest(count % 2**64, 2**64) == count
    assert not counting.Estimate(float(count), 2.0**-20).settles(2**64)
    assert not counting.Estimate(inf, 2.0**-40).settles(2**64)


@given(
    value=st.integers(2**60, 2**140),
    error=st.floats(1e-30, 1e-3),
    off=st.floats(-1, 1),
)
def test_a_residue_that_is_settled_is_settled_rightly_however_far_off(value, error, off):
    """The count lies within the relative error of the estimate, whichever way."""
    estimate = counting.Estimate(float(value), error)
    count = int(float(value) / (1 + off * error))
    assume(estimate.settles(2**64))
    assert estimate.nearest(count % 2**64, 2**64) == count
    assert count <= estimate.bound


@pytest.mark.parametrize("share, settled", [(0.24, True), (0.26, False)])
def test_a_residue_is_settled_by_an_error_of_less_than_a_quarter_of_its_modulus(share, settled):
    # Half of the modulus is the limit; the other half of that allows for the bound's rounding.
    value = 2.0**90
    estimate = counting.Estimate(value, share * 2**64 / (2 * value))
    assert estimate.settles(2**64) is settled


def test_multiples_of_five_are_impossible_at_0_and_2_3_um_and_possible_between(column):
    fives = {"0 um": 0, "0.5 um": 4, "1.2 um": 17, "2.3 um": 0}
    for c in read(Path("biet2007_table3")).columns:
        more = {"maximum_deviation": c.maximum_deviation.text}
        s = Solutions(column(12, c.mean.text, c.sd.text, step=5, **more))
        assert s.multisets == fives[c.label]


def test_a_table_of_states_that_does_not_fit_is_refused_before_it_starts(column):
    solutions = Solutions(column(60, "500.00", "200.00", maximum=1000))
    with pytest.raises(UserError, match=r"needs about [\d.]+ GiB and takes about \d+ h"):
        _ = solutions.multisets


def test_fractional_steps_match_enumeration(column, all_multisets):
    c = column(5, "1.40", "0.55", minimum=0, maximum=3, step=Fraction(1, 2))
    assert Solutions(c).multisets == len(all_multisets(c)) > 0
