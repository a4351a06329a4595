"""Required ratings: few parts, the same counts as enumeration, and a refusal before many parts."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.analysis.reconstruction.answers import column_answer
from slipscale.analysis.reconstruction.counts.partition import partition
from slipscale.analysis.reconstruction.data_sets import solutions as solutions_module
from slipscale.analysis.reconstruction.data_sets.batch import verdict
from slipscale.analysis.reconstruction.data_sets.marginals import marginals
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.data_sets.witness import gives_what_is_printed
from slipscale.analysis.reconstruction.table.table_files import Row

WIDE = {"mean": "50.1", "sd": "20.5"}


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
@pytest.mark.parametrize("median", ["1", "1.5", "2", "2.0", "2.5", "2.50"])
def test_every_median_leaves_what_enumeration_leaves(column, all_multisets, orders, n, median):
    for told in ({}, {"present": (2,)}, {"frequencies": [(2, 2)]}):
        for mean in ("1", "2", "2.5"):
            c = column(n, mean, None, maximum=4, median=median, **told)
            found = all_multisets(c)
            assert Solutions(c).multisets == len(found)
            assert Solutions(c).ordered == sum(orders(x) for x in found)


@st.composite
def columns(draw):
    """Keyword arguments of a column with required ratings, made from ratings."""
    n, top = draw(st.integers(2, 6)), draw(st.integers(1, 5))
    x = sorted(draw(st.lists(st.integers(0, top), min_size=n, max_size=n)))
    places = draw(st.integers(0, 1))
    mean = sum(x) / n
    printed = {
        "median": (x[(n - 1) // 2] + x[n // 2]) / 2,
        "observed_minimum": x[0],
        "observed_maximum": x[-1],
        "maximum_deviation": max(x[-1] - mean, mean - x[0]),
    }
    kept = draw(st.sets(st.sampled_from(sorted(printed)), min_size=1))
    present = draw(st.sets(st.sampled_from(x), max_size=2))
    facts = {name: f"{printed[name]:.{places}f}" for name in kept}
    return {"n": n, "maximum": top, "mean": f"{mean:.{places}f}", "sd": None} | (
        facts | {"present": tuple(map(Fraction, sorted(present)))}
    )


@settings(max_examples=40, deadline=None)
@given(facts=columns(), measure=st.sampled_from(["multisets", "ordered"]))
def test_required_ratings_are_listed_and_ranked_as_enumeration_does(
    column, all_multisets, orders, facts, measure
):
    c = column(**facts)
    found = all_multisets(c)
    assert sorted(map(tuple, Solutions(c).listed.tolist())) == sorted(found)
    if not found:
        return
    weights = [orders(x) if measure == "ordered" else 1 for x in found]
    exact = marginals(Solutions(c, minutes=1.0), measure)
    for value in range(c.scale.steps + 1):
        lacking = sum(w for x, w in zip(found, weights, strict=True) if value not in x)
        assert exact.absent[value] == lacking
    for rank in range(1, c.n + 1):
        expected: dict[int, Fraction] = {}
        for x, w in zip(found, weights, strict=True):
            share = Fraction(w, sum(weights))
            expected[x[rank - 1]] = expected.get(x[rank - 1], Fraction(0)) + share
        assert exact.order_statistic(rank) == expected


@pytest.mark.parametrize(
    "n, more, parts",
    [
        (20, {"median": "50"}, 151),
        (21, {"median": "50"}, 1),
        (40, {"observed_minimum": "0", "observed_maximum": "100"}, 1),
        (40, {"present": (5, 50, 70)}, 1),
    ],
    ids=str,
)
def test_required_ratings_need_few_parts_per_sum_and_sum_of_squares(column, n, more, parts):
    solutions = Solutions(column(n, **WIDE, **more))
    goals = sum(len(task.goals) for task in solutions.problems)
    assert goals <= parts * len(solutions.targets.wanted)


@pytest.mark.parametrize(
    "facts, more, said",
    [
        ((400, "50.1", "20.5"), {"median": "50"}, "counting needs about"),
        (
            (1000, "3.0", "1.5"),
            {"maximum": 6, "percentages": [(5, "5"), (6, "6")]},
            "combinations of a sum, a sum of squares",
        ),
    ],
    ids=str,
)
def test_too_many_parts_are_refused_before_they_are_listed(column, monkeypatch, facts, more, said):
    def listed(every, *measure):
        assert len(every) == 1
        return partition(every, *measure)

    c = column(*facts, **more)
    monkeypatch.setattr(solutions_module, "partition", listed)
    assert said in Solutions(c).refused
    row = Row(line=2, cells=("i",), column=c, told=())
    assert verdict(row, 4.0, 0.1).verdict == "not counted"


def test_a_few_parts_are_listed_under_any_limits(column):
    """Few values are counted by a formula, which takes no time worth limiting."""
    solutions = Solutions(column(10, "3.4", "1.2", maximum=7), minutes=0.0)
    assert not solutions.refused
    assert solutions.problems
    assert "counting needs about" in Solutions(column(12, "50.00", "10.00"), minutes=0.0).refused


def test_a_column_with_too_many_parts_has_a_witness(column):
    c = column(400, **WIDE, median="50")
    answer = column_answer(Solutions(c), "multisets")
    assert answer.consistent
    assert answer.grimmer
    assert gives_what_is_printed(c, [int(v) for v in answer.witness])


def test_ordered_samples_with_too_many_parts_are_left_but_multisets_are_counted(column):
    c = column(12, "50.1", "5.5", median="50")
    assert column_answer(Solutions(c), "multisets").ordered is None
    few = Solutions(c, minutes=0.001)
    answer = column_answer(few, "ordered")
    assert answer.multisets == Solutions(c).multisets > 0
    assert answer.ordered is None
    assert "combinations of a sum" in answer.not_drawn


def test_samples_with_an_even_median_are_all_that_enumeration_finds(column, all_multisets):
    c = column(6, "2", "1", maximum=4, median="2")
    found = all_multisets(c)
    for measure in ("multisets", "ordered"):
        rows = Sampler(Solutions(c), measure).draw(2000, np.random.default_rng(1))
        assert {tuple(sorted(row)) for row in rows.tolist()} == set(found)
