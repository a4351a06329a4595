"""Columns with too many data sets to count: refused at once, with what is known all the same."""

from __future__ import annotations

import sys
from fractions import Fraction

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from slipscale.analysis.published.printed_numbers import Printed
from slipscale.analysis.reconstruction.answers import column_answer
from slipscale.analysis.reconstruction.counts.partition import Moments
from slipscale.analysis.reconstruction.counts.problem import seconds_to_count
from slipscale.analysis.reconstruction.data_sets.constraints import targets, within_reach
from slipscale.analysis.reconstruction.data_sets.saddle_point import log10_multisets
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.data_sets.witness import gives_what_is_printed, witness
from slipscale.analysis.reconstruction.report import column_json, column_lines
from slipscale.analysis.reconstruction.table.table_files import from_csv
from slipscale.faults import UserError

RATINGS = st.lists(st.integers(0, 9), min_size=2, max_size=9)


@given(RATINGS)
def test_no_rating_lies_where_its_sums_exclude_it(x):
    low, high = within_reach(Moments(len(x), sum(x), sum(v * v for v in x)), 9)
    assert low <= min(x) <= max(x) <= high


def test_ratings_that_the_sd_excludes_cost_nothing(column):
    """On 0 to a thousand million only those near the mean are looked at."""
    narrow = Solutions(column(5, "500.0", "2.0", maximum=1000))
    wide = Solutions(column(5, "500000000.0", "2.0", maximum=1_000_000_000))
    assert wide.multisets == narrow.multisets == 3


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
@pytest.mark.parametrize(
    "more",
    [
        {},
        {"median": "10"},
        {"observed_minimum": "0"},
        {"maximum_deviation": "27"},
        {"percentages": ((0, "20"),)},
    ],
    ids=["plain", "median", "minimum", "deviation", "an impossible share"],
)
@pytest.mark.parametrize("step", ["1/10", "1/1000", "1/1000000"])
@pytest.mark.parametrize("mean", ["13", "12.7500"])
def test_a_fine_scale_is_answered_within_the_memory_of_few_ratings(column, step, mean, more):
    """Listed whole, what is printed would fill gigabytes, and the process may have 500 MB."""
    from tests.fuzzing.bounds import limited_memory

    shares = tuple((Fraction(v), Printed(share)) for v, share in more.get("percentages", ()))
    fine = column(12, mean, mean, step=step, **{**more, "percentages": shares})
    with limited_memory():
        found = targets(fine)
        estimate = log10_multisets(found)
    assert bool(found.reason) == bool(shares)
    if step == "1/1000000" or shares:
        assert found.wanted == ()
        assert estimate is None


def test_a_scale_too_fine_to_compute_with_is_refused_in_a_sentence(column):
    with pytest.raises(ValueError, match=r"100,000,000,000 steps of .*; expected at most 8"):
        column(12, "13", "13", step="1/1000000000")


def test_columns_whose_common_scale_is_too_fine_keep_their_own():
    text = "n,mean,sd\n12,999999999999999,1\n12,0,1\n"
    scales = {column.scale.maximum for column in from_csv(text).columns}
    assert len(scales) == 2


@pytest.mark.parametrize(
    "facts, said",
    [
        (
            (20_000, "4.00", "1.50", 7),
            r"about \d\.\d GiB and takes about \d+ h; 4 GiB and 0.1 min",
        ),
        ((300, "50.00", "10.00", 100), r"takes about \d\d min"),
        ((5, "50000.0", "20000.0", 100_000), "needs about"),
        ((5, "500000000.0", "200000000.00", 1_000_000_000), "too few decimals for n = 5"),
        ((1_000_000, "4.00", "1.50", 7), "too few decimals for n = 1,000,000"),
    ],
)
def test_what_cannot_be_counted_is_refused_with_its_reason(column, facts, said):
    n, mean, sd, maximum = facts
    solutions = Solutions(column(n, mean, sd, maximum=maximum))
    with pytest.raises(UserError, match=said):
        _ = solutions.multisets


def test_an_answer_without_a_count_has_a_witness_and_an_estimate(column):
    answer = column_answer(Solutions(column(200, "50.00", "10.00"), minutes=1.0), "multisets")
    assert answer.multisets is None
    assert answer.consistent
    assert "1 min are allowed" in answer.refused
    assert sum(answer.witness) == 200 * 50
    assert 40 < answer.log10_estimate < 55


@pytest.mark.parametrize("convention", ["sample", "population"])
def test_a_convention_that_takes_too_long_is_not_counted_but_the_other_is(column, convention):
    """An SD that divides by n admits more sums: 1.00 s instead of .95 s, of .98 s allowed."""
    solutions = Solutions(column(40, "50.00", "10.00"), minutes=0.98 / 60)
    answer = column_answer(solutions.under(convention, "nearest"), "multisets", variants=True)
    assert {each.sd_convention for each in answer.variants if each.multisets} == {"sample"}
    left = [each for each in answer.variants if each.multisets is None]
    assert {each.sd_convention for each in left} == {"population"}
    assert all("min are allowed" in each.reason for each in left)
    lines = [line for line in column_lines(answer) if line.startswith("    population nearest")]
    assert lines[0].split()[2:4] == ["not", "counted:"]
    assert [each["consistent"] for each in column_json(answer)["variants"]] == 4 * [True] + 4 * [
        None
    ]


def test_what_fits_no_table_is_counted_but_not_drawn(column):
    """Of 60 ratings on 0 to 100 the planes need 0.1 GiB, the tables of states 0.5."""
    drawn, counted = (Solutions(column(60, "50.00", "5.00"), memory_gib=gib) for gib in (1.0, 0.05))
    answer = column_answer(counted, "multisets")
    assert answer.multisets == drawn.multisets
    assert not drawn.not_drawn
    assert "the state table needs about" in answer.not_drawn
    assert answer.ordered is None


@pytest.mark.parametrize(
    "facts, within",
    [
        ((12, "50.00", "10.00", 0, 100), 1.11),
        ((50, "50.00", "10.00", 0, 100), 1.03),
        ((50, "4.00", "1.50", 1, 7), 1.03),
        ((130, "2.7", "1.9", 1, 5), 1.11),
    ],
)
def test_the_saddle_point_estimate_is_near_the_exact_count(column, facts, within):
    n, mean, sd, low, high = facts
    solutions = Solutions(column(n, mean, sd, minimum=low, maximum=high))
    ratio = 10 ** log10_multisets(solutions.targets) / solutions.multisets
    assert 1 / within < ratio < within


@pytest.mark.parametrize(
    "facts, extremes",
    [
        ((12, "50.00", "10.00"), {"observed_maximum": "66"}),
        ((12, "50.00", "10.00"), {"maximum_deviation": "18.00"}),
        ((30, "50.00", "10.00"), {"observed_maximum": "70", "observed_minimum": "31"}),
    ],
)
def test_printed_extremes_are_estimated_within_a_fifth(column, facts, extremes):
    solutions = Solutions(column(*facts, **extremes))
    ratio = 10 ** log10_multisets(solutions.targets) / solutions.multisets
    assert 1 / 1.2 < ratio < 1.2


def test_medians_are_not_estimated(column):
    solutions = Solutions(column(12, "50.00", "10.00", median="50"))
    assert log10_multisets(solutions.targets) is None


def test_too_few_decimals_leave_a_witness_and_an_estimate(column):
    """Some pairs of sum and sum of squares stand for all, where all can still be counted."""
    listed = Solutions(column(40, "50.0", "20"))
    pairs = len(listed.targets.wanted)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("slipscale.analysis.reconstruction.data_sets.constraints.MOST_PAIRS", 10)
        answer = column_answer(Solutions(listed.column), "multisets")
    assert pairs > 10
    assert "too few decimals" in answer.refused
    assert gives_what_is_printed(listed.column, [int(v) for v in answer.witness])
    # Sums of squares that are not looked at have more or fewer; together about as many.
    assert answer.log10_estimate == pytest.approx(log10_multisets(listed.targets), abs=0.05)


def test_counting_is_timed_by_its_cells_and_its_bits(column):
    short, long = (Solutions(column(n, "50.00", "10.00")).problems for n in (30, 60))
    assert seconds_to_count(short) < 1
    assert 1 < seconds_to_count(long) < 10


@settings(max_examples=50, deadline=None)
@given(x=st.lists(st.integers(0, 9), min_size=4, max_size=30), places=st.integers(1, 2))
def test_a_witness_is_one_of_the_data_sets_that_are_counted(column, x, places):
    n, mean = len(x), sum(x) / len(x)
    sd = (sum((v - mean) ** 2 for v in x) / (n - 1)) ** 0.5
    printed = column(n, f"{mean:.{places}f}", f"{sd:.{places}f}", maximum=9)
    solutions = Solutions(printed)
    assume(solutions.targets.wanted)
    found = witness(printed, solutions.targets)
    assert gives_what_is_printed(printed, found) if found else True
    if found:
        assert solutions.multisets > 0
    # Where ratings are many the search succeeds.
    assert found or n < 12


def test_the_definitions_decide_what_a_data_set_prints(column, all_multisets):
    facts = {"n": 4, "mean": "2.3", "sd": "1.7", "maximum": 5, "maximum_deviation": "2.3"}
    printed = column(**facts)
    every = all_multisets(column(**(facts | {"mean": "2", "sd": "2", "maximum_deviation": "2"})))
    right = set(all_multisets(printed))
    assert {x for x in every if gives_what_is_printed(printed, x)} == right & set(every)
    assert right
