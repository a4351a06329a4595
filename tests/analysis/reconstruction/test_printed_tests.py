"""Printed tests against every pair of data sets and every pairing."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest
from scipy.stats import f_oneway, pearsonr, ttest_ind, ttest_rel

from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference.printed_test_answers import answer
from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest
from slipscale.analysis.reconstruction.table.table_files import from_toml
from slipscale.faults import UserError

FACTS = [(4, "2", "1.7"), (4, "3.5", "1"), (3, "1.0", "1.0")]


@pytest.fixture(scope="module")
def groups(column):
    return [Solutions(column(*facts, maximum=6)) for facts in FACTS]


@pytest.fixture(scope="module")
def every(column, all_multisets):
    return [np.array(all_multisets(column(*facts, maximum=6)), float) for facts in FACTS]


def every_value(kind, every):
    """Every pair of a statistic, as papers print it, and p."""
    if kind == "one_way_f":
        return [f_oneway(*rows) for rows in product(*every)]
    if kind in ("independent_t", "welch_t"):
        equal = kind == "independent_t"
        return [ttest_ind(b, a, equal_var=equal) for a, b in product(every[0], every[1])]
    pairs = [(a, np.array(b)) for a in every[0] for row in every[1] for b in permutations(row)]
    test = {"paired_t": ttest_rel, "correlation": pearsonr}[kind]
    return [test(b, a) for a, b in pairs if np.ptp(b - a) or kind == "correlation"]


@pytest.mark.parametrize(
    "kind", ["paired_t", "independent_t", "welch_t", "one_way_f", "correlation"]
)
def test_a_printed_test_is_possible_where_some_data_set_prints_it(groups, every, kind):
    chosen = groups if kind == "one_way_f" else groups[:2]
    found = every_value(kind, every)
    values = [float(r.statistic) for r in found]
    if kind != "correlation":
        values = [abs(value) for value in values]
    said = set()
    for hundredths in range(-100, 800, 7):
        text = f"{hundredths / 100:.2f}"
        if hundredths < 0 and kind != "correlation":
            continue
        there = any(abs(value - hundredths / 100) <= 0.005 + 1e-12 for value in values)
        one = answer(PrintedTest(kind=kind, statistic=text), chosen)
        said.add(one.verdict)
        assert (one.verdict == "possible") == there or one.verdict == "not decided", text
        if one.verdict == "not decided":
            # Sums of products that fit by Cauchy and Schwarz, but that no pairing has.
            assert kind in ("paired_t", "correlation")
            assert not there
        if one.example:
            test = pearsonr if kind == "correlation" else ttest_rel
            value = test(*map(np.array, reversed(one.example))).statistic
            assert abs(abs(value) - abs(hundredths / 100)) <= 0.005 + 1e-9
            assert {tuple(sorted(row)) for row in one.example} <= {
                tuple(row) for rows in every[:2] for row in rows.tolist()
            }
    assert {"possible", "impossible"} <= said
    assert one.low <= min(float(r.statistic) for r in found) + 1e-9
    assert one.high >= max(float(r.statistic) for r in found) - 1e-9


@pytest.mark.parametrize("kind", ["paired_t", "independent_t", "welch_t", "one_way_f"])
def test_a_printed_p_is_possible_where_some_data_set_prints_it(groups, every, kind):
    chosen = groups if kind == "one_way_f" else groups[:2]
    ps = [float(r.pvalue) for r in every_value(kind, every)]
    for thousandths in range(5, 1000, 61):
        there = any(abs(p - thousandths / 1000) <= 0.0005 + 1e-12 for p in ps)
        one = answer(PrintedTest(kind=kind, p=f"{thousandths / 1000:.3f}"), chosen)
        assert (one.verdict == "possible") == there or one.verdict == "not decided"
        assert one.verdict != "not decided" or not there
    assert answer(PrintedTest(kind=kind, p_below=".00001"), chosen).verdict != "possible"
    assert answer(PrintedTest(kind=kind, p_below="0.99"), chosen).verdict == "possible"


def test_a_printed_t_settles_the_correlation(groups, every):
    values = sorted(abs(float(r.statistic)) for r in every_value("paired_t", every))
    printed = f"{values[len(values) // 2]:.2f}"
    one = answer(PrintedTest(kind="paired_t", statistic=printed), groups[:2])
    fit = [
        pearsonr(a, np.array(b)).statistic
        for a in every[0]
        for row in every[1]
        for b in permutations(row)
        if abs(abs(ttest_rel(np.array(b), a).statistic) - float(printed)) <= 0.005
    ]
    assert fit
    assert one.correlation_low - 1e-9 <= min(fit) <= max(fit) <= one.correlation_high + 1e-9
    assert 0 < one.pairs_left <= one.pairs


def test_with_printed_decimals_a_t_leaves_little_of_the_correlation(column):
    """By hand: SD² of the differences is 100 + 144 - 240 r, and t is 10 over its SD over √12."""
    table = [Solutions(column(12, "50.00", "10.00")), Solutions(column(12, "60.00", "12.00"))]
    one = answer(PrintedTest(kind="paired_t", statistic="3.00"), table)
    assert one.correlation_low < (244 - 12 * 100 / 9) / 240 < one.correlation_high
    assert one.correlation_high - one.correlation_low < 0.01


def test_a_repeated_measures_f_below_the_least_is_impossible(groups):
    one = answer(PrintedTest(kind="rm_f", statistic="0.01"), groups[:2])
    assert one.verdict == "impossible"
    assert answer(PrintedTest(kind="rm_f", statistic="99.1"), groups[:2]).verdict == "not decided"


def test_a_test_on_a_column_without_any_data_set_is_impossible(groups, column):
    bad = Solutions(column(4, "2.1", "1.7", maximum=6))
    assert (
        answer(PrintedTest(kind="welch_t", statistic="1"), [bad, groups[1]]).verdict == "impossible"
    )


def test_columns_whose_sums_cannot_be_listed_are_not_decided(groups, column):
    many = Solutions(column(4, "1000000", "300000", maximum=2_000_000))
    assert many.targets.refused
    one = answer(PrintedTest(kind="independent_t", statistic="1"), [many, groups[0]])
    assert one.verdict == "not decided"


TABLE = """
[scale]
maximum = 6
[[column]]
label = "a"
n = 4
mean = "2.2"
sd = "1.7"
[[column]]
n = 4
mean = "3.5"
sd = "1.3"
[[test]]
kind = "paired_t"
columns = ["a", "column 2"]
statistic = "1.93"
"""


def test_tests_are_read_with_the_table():
    (test,) = from_toml(TABLE).tests
    assert test.columns == ("a", "column 2")


@pytest.mark.parametrize(
    "old, new, said",
    [
        (
            '"column 2"]',
            '"b"]',
            r"line 15, columns of item 1 of test: there is no column 'b'",
        ),
        ('statistic = "1.93"', "", r"line 13, item 1 of test: expected a statistic, p or p_below"),
        (
            'kind = "paired_t"',
            'kind = "t"',
            r"line 14, kind of item 1 of test: .*'independent_t'",
        ),
        ('statistic = "1.93"', 'p_below = "0"', "line 13, item 1 of test: p_below is 0 or less"),
        ('["a", "column 2"]', '["a"]', "expected two or more different columns"),
        ('kind = "paired_t"', 'kind = "rm_f"\np = ".01"', "leave out the p"),
    ],
)
def test_a_wrong_test_is_refused_with_its_line(old, new, said):
    with pytest.raises(UserError, match=said):
        from_toml(TABLE.replace(old, new))


def test_a_test_of_two_columns_says_which(groups):
    with pytest.raises(UserError, match="expected the labels of its two columns"):
        answer(PrintedTest(kind="paired_t", statistic="1"), groups)
