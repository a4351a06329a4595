"""Exact marginals against complete enumeration."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from slipscale.analysis.reconstruction.data_sets.marginals import marginals
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.table_files import read

CASES = [
    {"n": 6, "mean": "3.50", "sd": "1.87", "maximum": 8},
    {"n": 5, "mean": "2.4", "sd": "1.1", "maximum": 6, "maximum_deviation": "1.6"},
    {"n": 6, "mean": "3.5", "sd": "1.9", "maximum": 8, "median": "3.5"},
    {"n": 2, "mean": "0", "sd": "0", "maximum": 1, "maximum_deviation": "0"},
    # Nothing lies below the median: it is the scale's end.
    {"n": 5, "mean": "0.20", "sd": "0.45", "maximum": 4, "median": "0.0"},
]


@pytest.mark.parametrize("measure", ["multisets", "ordered"])
@pytest.mark.parametrize("facts", CASES)
def test_marginals_are_those_of_all_data_sets(column, all_multisets, orders, facts, measure):
    c = column(**facts)
    weight = {x: orders(x) if measure == "ordered" else 1 for x in all_multisets(c)}
    total = sum(weight.values())
    found = marginals(Solutions(c), measure)
    assert found.total == total
    for value in range(c.scale.steps + 1):
        for i in range(1, c.n + 1):
            share = Fraction(sum(w for x, w in weight.items() if x[i - 1] == value), total)
            assert found.order_statistic(i).get(value, 0) == share
        assert found.presence(value) == Fraction(
            sum(w for x, w in weight.items() if value in x), total
        )
        assert found.rating().get(value, 0) == Fraction(
            sum(w * x.count(value) for x, w in weight.items()), total * c.n
        )


def test_somebody_rated_zero_in_more_than_half_of_the_data_sets_of_table_3():
    solutions = Solutions(read(Path("biet2007_table3")).columns[0])
    assert round(float(marginals(solutions).presence(0)), 3) == 0.549
    assert round(float(marginals(solutions, "ordered").presence(0)), 3) == 0.649
