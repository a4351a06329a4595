"""Independent groups: the ranges against every pair of data sets."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.stats import f_oneway, ttest_ind

from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference import independent
from slipscale.analysis.reconstruction.inference.independent import independent_conclusions
from slipscale.faults import UserError

# One decimal: several sums and sums of squares each; groups of different sizes.
FACTS = [(4, "2.3", "1.7"), (5, "4.4", "1.1"), (3, "1.0", "1.0")]


@pytest.fixture(scope="module")
def groups(column):
    return [Solutions(column(*facts, maximum=6)) for facts in FACTS]


@pytest.fixture(scope="module")
def every(column, all_multisets):
    return [np.array(all_multisets(column(*facts, maximum=6)), float) for facts in FACTS]


@pytest.mark.parametrize("name, equal", [("student_t", True), ("welch_t", False)])
def test_t_and_p_range_over_every_pair_of_data_sets(groups, every, name, equal):
    (found, *_) = [c for c in independent_conclusions(groups[:2]) if c.name.startswith(name)]
    all_of = [ttest_ind(b, a, equal_var=equal) for a, b in product(every[0], every[1])]
    assert found.low == pytest.approx(min(one.statistic for one in all_of))
    assert found.high == pytest.approx(max(one.statistic for one in all_of))
    assert found.p_low == pytest.approx(min(one.pvalue for one in all_of))
    assert found.p_high == pytest.approx(max(one.pvalue for one in all_of))
    assert found.sharp


def test_one_way_f_lies_within_its_bounds_for_every_triple(groups, every):
    found = independent_conclusions(groups)[-1]
    values = [f_oneway(*three).statistic for three in product(*every)]
    assert found.name == "one_way_f"
    assert found.low <= min(values) * (1 + 1e-9)
    assert found.high >= max(values) * (1 - 1e-9)


def test_one_way_f_of_columns_with_one_sum_each_is_sharp(column, all_multisets):
    facts = [(4, "2.25", "1.71"), (5, "4.40", "1.14")]
    columns = [column(*each, maximum=6) for each in facts]
    found = independent_conclusions([Solutions(c) for c in columns])[-1]
    both = product(*[np.array(all_multisets(c), float) for c in columns])
    values = [f_oneway(*two).statistic for two in both]
    assert (found.low, found.high) == (pytest.approx(min(values)), pytest.approx(max(values)))
    assert found.sharp


def test_many_sums_are_answered_by_their_extremes(groups, monkeypatch):
    whole = independent_conclusions(groups[:2])
    monkeypatch.setattr(independent, "ALL_OF", 0)
    few = independent_conclusions(groups[:2])
    assert [(c.low, c.high) for c in few] == [(c.low, c.high) for c in whole]
    assert [c.sharp for c in few[:2]] == [True, False]


def test_columns_too_large_to_count_have_their_ranges_too(column):
    large = [
        Solutions(column(500, mean, "1.50", minimum=1, maximum=7), minutes=0.0)
        for mean in ("4.00", "4.10")
    ]
    t = independent_conclusions(large)[0]
    assert t.low < 0.1 / (1.5 * (2 / 500) ** 0.5) < t.high
    assert not t.sharp


def test_one_column_cannot_be_compared(groups):
    with pytest.raises(UserError, match="expected two or more"):
        independent_conclusions(groups[:1])


def test_without_any_variation_t_is_infinite_or_zero(column):
    flat = [Solutions(column(3, mean, "0.00", maximum=6)) for mean in ("2.00", "2.00", "3.00")]
    found = {c.name: c for c in independent_conclusions(flat[:2])}
    assert found["student_t.x.x"].high == 0
    assert independent_conclusions(flat[1:])[1].low == np.inf
