"""The counts' own arithmetic: bounds that must not be passed, memory, estimates and residues."""

from __future__ import annotations

from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.analysis.reconstruction.counts import problem
from slipscale.analysis.reconstruction.counts.counting import (
    Estimate,
    attained,
    count,
    estimate,
    largest_possible,
)
from slipscale.analysis.reconstruction.counts.problem import require_memory, simple_bound
from slipscale.analysis.reconstruction.counts.residues import WORD
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.faults import UserError


@pytest.fixture(scope="module")
def whole(column):
    """Free values only: no extreme is printed, so there is one part for each sum of squares."""
    return Solutions(column(5, "2.40", "1.14", maximum=6)).problems


@pytest.fixture(scope="module")
def with_extreme(column):
    solutions = Solutions(column(5, "2.40", "1.14", maximum=6, observed_minimum="1"))
    return {"multisets": solutions.problems, "ordered": solutions.ordered_problems}


def test_the_simple_bound_is_every_choice_of_free_values(whole):
    (task,) = whole
    values = task.split.high - task.split.low + 1
    goals = len(task.goals)
    assert simple_bound(whole, "multisets") == goals * comb(5 + values - 1, 5)
    assert simple_bound(whole, "ordered") == goals * values**5


def test_given_values_have_their_places_among_the_ordered(with_extreme):
    expected = sum(
        (task.split.high - task.split.low + 1) ** goal.n * goal.part.arrangements
        for task in with_extreme["ordered"]
        for goal in task.goals
    )
    assert simple_bound(with_extreme["ordered"], "ordered") == expected


@pytest.mark.parametrize("measure", ["multisets", "ordered"])
def test_no_count_passes_its_bounds(whole, with_extreme, measure):
    for tasks in (whole, with_extreme[measure]):
        exact = count(tasks, measure)
        assert 0 < exact <= largest_possible(tasks, measure) <= simple_bound(tasks, measure)
        about = estimate(tasks, measure)
        # Small counts have no rounding: floating point holds them exactly.
        assert about.value == exact
        assert 0 < about.error < 1e-12


def test_what_is_possible_beyond_a_word_is_bounded_closely(column):
    tasks = Solutions(column(16, "50.00", "10.00")).problems
    exact = count(tasks, "ordered")
    assert exact > WORD
    assert exact < largest_possible(tasks, "ordered") < exact * (1 + 1e-9)


def test_nothing_at_all_is_none():
    assert count([], "multisets") == 0
    assert estimate([], "multisets") == Estimate(0.0, 0.0)
    require_memory([], 0.0)


def test_memory_is_eight_bytes_a_cell_of_both_tables_and_its_limit_is_kept(whole):
    (task,) = whole
    cells = sum((a + 1) * (w + 1) for shape in (task.below, task.above) for a, w in shape.reach)
    assert task.bytes == 8 * cells
    gib = task.bytes / 2**30
    require_memory(whole, gib)
    require_memory(whole, 3 * gib, 3)
    with pytest.raises(UserError, match="GiB"):
        require_memory(whole, gib * 0.999)
    with pytest.raises(UserError, match="GiB"):
        require_memory(whole, 2.9 * gib, 3)


@given(value=st.floats(0, 1e300), error=st.floats(0, 0.25))
def test_the_bound_of_an_estimate_covers_every_count_that_it_allows(value, error):
    """The count is off by at most the error, relative to itself or to the estimate."""
    largest = value / (1 - error)
    assert Estimate(value, error).bound >= largest


def test_the_bound_of_an_estimate_is_not_wasteful():
    assert Estimate(1000.0, 0.01).bound == 1021.0


@given(value=st.integers(0, 2**100), off=st.integers(-(2**63), 2**63 - 1))
def test_the_nearest_number_with_a_residue_is_found_on_either_side(value, off):
    about = Estimate(float(value), 0.0)
    wanted = int(about.value) + off
    assert about.nearest(wanted % WORD, WORD) == wanted


def test_sums_that_no_data_set_has_are_not_attained(column, all_multisets):
    c = column(4, "2", "2", maximum=5, observed_maximum="5")
    solutions = Solutions(c)
    exact = {(sum(x), sum(v * v for v in x)) for x in all_multisets(c)}
    assert attained(solutions.problems) == exact
    assert exact < {(m.total, m.squares) for m in solutions.targets.moments}
    with pytest.raises(UserError, match="GiB"):
        attained(solutions.problems, 0.0)


def test_by_default_four_gib_are_allowed():
    assert problem.MEMORY_GIB == 4.0
