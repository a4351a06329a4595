"""Every way of counting multisets gives what the tables of states, and enumeration, give."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.analysis.reconstruction.counts import few_values, plane_by_plane
from slipscale.analysis.reconstruction.counts.counting import count, estimate
from slipscale.analysis.reconstruction.counts.residues import WORD
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions

PRIME = 2**31 - 1


def table_count(tasks, modulus):
    """Return the count by joining both tables."""
    joined = [
        sum(int((j.below.astype(object) * j.above.astype(object)).sum()) for j in joints)
        for joints in (task.joints(*task.tables("multisets", modulus)) for task in tasks)
    ]
    return sum(joined) % modulus


def plane_count(tasks, modulus):
    found = sum(
        plane_by_plane.number(task.below, task.above, task.goals, modulus) for task in tasks
    )
    return found if modulus is None else found % modulus


COLUMNS = [
    (12, "50.00", "10.00", {}),
    (12, "12.75", "12.75", {"maximum_deviation": "27.25"}),
    (6, "15", "6", {"maximum": 30}),  # several sums, and runs of sums of squares
    (9, "30.0", "12.3", {"maximum": 50, "median": "28"}),
    (10, "30.0", "12.3", {"maximum": 50, "median": "28.0"}),
    (8, "3.50", "3.74", {"maximum": 7}),  # far below and far above only
    (30, "6.0", "2.0", {"maximum": 12}),
    (12, "50.00", "10.00", {"absent": (44, 50, 51, 53, 60)}),
    (12, "50.00", "10.00", {"absent": (49, 51), "frequencies": [(50, 2), (48, 1)]}),
]


@pytest.mark.parametrize("facts", COLUMNS, ids=str)
def test_planes_give_what_tables_give(column, facts):
    *printed, more = facts
    tasks = Solutions(column(*printed, **more)).problems
    for modulus in (WORD, PRIME):
        assert plane_count(tasks, modulus) == table_count(tasks, modulus)
    assert plane_count(tasks, None) == pytest.approx(estimate(tasks, "multisets").value, rel=1e-12)


def test_residues_are_reduced_before_they_overflow(column):
    """Modulo a small prime and beyond a machine word, where a missed reduction shows."""
    tasks = Solutions(column(80, "50.00", "6.00")).problems
    exact = count(tasks, "multisets")
    assert exact > WORD
    assert plane_count(tasks, PRIME) == exact % PRIME


@pytest.mark.parametrize("length", [1, 2, 3, 7, 8, 13])
@pytest.mark.parametrize("before, after", [(0, 0), (2, 0), (0, 5), (6, 6)])
def test_sums_of_neighbouring_columns_are_those_of_a_loop(length, before, after):
    cells = np.random.default_rng(1).integers(0, 99, (3, 20))
    if length == 1:
        before = after = 0
    padded = np.pad(cells, ((0, 0), (before, after)))
    slow = [padded[:, i : i + length].sum(axis=1) for i in range(padded.shape[1] - length + 1)]
    found = plane_by_plane._window(cells, before, after, length)
    assert found.tolist() == np.stack(slow, axis=1).tolist()


@st.composite
def likert(draw):
    """Keyword arguments of a column of few values, made from ratings."""
    top = draw(st.integers(2, 11))
    x = draw(st.lists(st.integers(0, top), min_size=2, max_size=25))
    n, places = len(x), draw(st.integers(0, 2))
    mean = sum(x) / n
    sd = (sum((v - mean) ** 2 for v in x) / (n - 1)) ** 0.5
    facts = {"n": n, "mean": f"{mean:.{places}f}", "sd": f"{sd:.{places}f}", "maximum": top}
    ends = {"observed_minimum": str(min(x)), "observed_maximum": str(max(x))}
    return facts | {name: ends[name] for name in draw(st.sets(st.sampled_from(sorted(ends))))}


@settings(max_examples=60, deadline=None)
@given(facts=likert())
def test_few_values_give_what_planes_give(column, facts):
    solutions = Solutions(column(**facts))
    for task in solutions.problems:
        exact = plane_count([task], WORD)
        assert task.of_few_values in (exact, None)
    assert solutions.multisets == plane_count(solutions.problems, WORD)


def test_few_values_are_used_for_likert_scales_and_left_where_choices_are_many(column):
    (few,) = Solutions(column(50, "4.00", "1.50", minimum=1, maximum=7)).problems
    assert few.of_few_values == 2792  # closure-core 1.0.0 counts as many
    (many,) = Solutions(column(500, "4.00", "1.50", minimum=1, maximum=7)).problems
    assert many.of_few_values is None
    (wide,) = Solutions(column(5, "50.00", "10.00")).problems
    assert wide.of_few_values is None
    medians = Solutions(column(9, "4.0", "1.5", minimum=1, maximum=7, median="4")).problems
    assert not any(few_values.without_median(goal) for task in medians for goal in task.goals)


def test_two_values_are_counted_by_planes(column, all_multisets):
    c = column(7, "0.43", "0.53", maximum=1)
    assert Solutions(c).problems[0].of_few_values is None
    assert Solutions(c).multisets == len(all_multisets(c)) == 1


@pytest.mark.parametrize("facts", COLUMNS, ids=str)
def test_cells_are_those_that_are_held(column, facts, monkeypatch):
    """The largest number held at once, followed through a count."""
    *printed, more = facts
    held = []
    meet = plane_by_plane._Meeting._meet

    def watched(self, run, k, left):
        above = sum(plane.values.size for plane in self.above.planes)
        below = sum(plane.values.size for plane in self.below.planes if plane.last >= left)
        held.append(above + below)
        return meet(self, run, k, left)

    monkeypatch.setattr(plane_by_plane._Meeting, "_meet", watched)
    for task in Solutions(column(*printed, **more)).problems:
        held.clear()
        plane_count([task], WORD)
        if held:
            assert max(held) <= plane_by_plane.cells(task.below, task.above, task.goals)
