"""Printed tests against every pair of data sets and every pairing."""

from __future__ import annotations

import tracemalloc
from functools import partial
from itertools import permutations, product

import numpy as np
import pytest
from scipy.stats import f_oneway, pearsonr, ttest_ind, ttest_rel

from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference import cross_products
from slipscale.analysis.reconstruction.inference.column_rows import ColumnRows
from slipscale.analysis.reconstruction.inference.printed_test_answers import answer
from slipscale.analysis.reconstruction.table.printed_tests import PrintedTest
from slipscale.analysis.reconstruction.table.table_files import from_toml
from slipscale.faults import UserError
from tests.analysis.reconstruction.truth_tables import campaign

FACTS = [(4, "2", "1.7"), (4, "3.5", "1"), (3, "1.0", "1.0")]


@pytest.fixture(scope="module")
def groups(column):
    return [Solutions(column(*facts, maximum=6)) for facts in FACTS]


@pytest.fixture(scope="module")
def every(column, all_multisets):
    return [np.array(all_multisets(column(*facts, maximum=6)), float) for facts in FACTS]


TESTS = {
    "paired_t": ttest_rel,
    "correlation": pearsonr,
    "independent_t": ttest_ind,
    "welch_t": partial(ttest_ind, equal_var=False),
    "one_way_f": f_oneway,
}


def every_value(kind, every):
    """Every pair of a statistic, as papers print it, and p."""
    if kind == "one_way_f":
        return [f_oneway(*rows) for rows in product(*every)]
    if kind in ("independent_t", "welch_t"):
        return [TESTS[kind](b, a) for a, b in product(every[0], every[1])]
    pairs = [(a, np.array(b)) for a in every[0] for row in every[1] for b in permutations(row)]
    return [TESTS[kind](b, a) for a, b in pairs if np.ptp(b - a) or kind == "correlation"]


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
        assert one.verdict == ("possible" if there else "impossible"), text
        if one.example:
            rows = [np.array(row) for row in reversed(one.example)]
            value = float(TESTS[kind](*rows).statistic)
            assert abs(abs(value) - abs(hundredths / 100)) <= 0.005 + 1e-9
            assert {tuple(sorted(row)) for row in one.example} <= {
                tuple(row) for rows in every for row in rows.tolist()
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
        assert one.verdict == ("possible" if there else "impossible")
    assert answer(PrintedTest(kind=kind, p_below=".00001"), chosen).verdict != "possible"
    assert answer(PrintedTest(kind=kind, p_below="0.99"), chosen).verdict == "possible"


def test_a_printed_t_settles_the_correlation(groups, every):
    pairs = [(a, np.array(b)) for a in every[0] for row in every[1] for b in permutations(row)]
    x, y = (np.array(rows) for rows in zip(*pairs, strict=True))
    ts = np.abs(ttest_rel(y, x, axis=1).statistic)
    printed = f"{np.nanmedian(ts):.2f}"
    one = answer(PrintedTest(kind="paired_t", statistic=printed), groups[:2])
    fit = pearsonr(x, y, axis=1).statistic[np.abs(ts - float(printed)) <= 0.005]
    assert one.correlation_low == pytest.approx(fit.min())
    assert one.correlation_high == pytest.approx(fit.max())
    assert 0 < one.pairs_left <= one.pairs


def test_with_printed_decimals_a_t_leaves_little_of_the_correlation(column):
    """By hand: SD² of the differences is 100 + 144 - 240 r, and t is 10 over its SD over √12."""
    table = [Solutions(column(12, "50.00", "10.00")), Solutions(column(12, "60.00", "12.00"))]
    one = answer(PrintedTest(kind="paired_t", statistic="3.00"), table)
    assert one.correlation_low < (244 - 12 * 100 / 9) / 240 < one.correlation_high
    assert one.correlation_high - one.correlation_low < 0.01


def test_a_repeated_measures_f_outside_its_extremes_is_impossible(groups, every):
    fs = [
        ttest_rel(np.array(b), a).statistic ** 2
        for a in every[0]
        for row in every[1]
        for b in permutations(row)
        if np.ptp(np.array(b) - a)
    ]
    for text in ("0.01", f"{max(fs) + 0.02:.2f}", "9999"):
        assert answer(PrintedTest(kind="rm_f", statistic=text), groups[:2]).verdict == "impossible"
    one = answer(PrintedTest(kind="rm_f", statistic=f"{max(fs):.2f}"), groups[:2])
    assert one.verdict == "possible"
    assert one.high == pytest.approx(max(fs))


def test_a_column_at_ceiling_does_not_make_a_true_t_impossible(column):
    """3.25 (1.04) before and 5.00 (0.00) after, n = 8 on 1 to 5: t(7) = 4.78 is what R prints."""
    before = Solutions(column(8, "3.25", "1.04", minimum=1, maximum=5))
    after = Solutions(column(8, "5.00", "0.00", minimum=1, maximum=5))
    one = answer(PrintedTest(kind="paired_t", statistic="4.78"), [before, after])
    assert one.verdict == "possible"
    assert ttest_rel(*map(np.array, reversed(one.example))).statistic == pytest.approx(4.78, 2e-3)
    # t = 1.75 / (1.0351 / √8) for every data set: no other t is possible.
    assert answer(PrintedTest(kind="paired_t", statistic="4.70"), [before, after]).verdict == (
        "impossible"
    )


@pytest.mark.parametrize("kind", ["paired_t", "independent_t", "one_way_f", "rm_f", "correlation"])
def test_constant_columns_have_no_statistic_to_print(column, kind):
    flat = [Solutions(column(5, mean, "0.00", maximum=6)) for mean in ("2.00", "3.00")]
    one = answer(PrintedTest(kind=kind, statistic="0.00"), flat)
    assert one.verdict == "impossible"
    assert "undefined" in one.reason


def test_identical_columns_do_not_print_a_t_of_zero(column):
    # The same two ratings: differences are 0, 0 or 1, -1; only the second has a t.
    same = [Solutions(column(2, "2.50", "0.71", maximum=6)) for _ in range(2)]
    one = answer(PrintedTest(kind="paired_t", statistic="0.00"), same)
    assert one.verdict == "possible"
    assert one.example[0] != one.example[1]


def test_an_effect_size_and_its_statistic_contradict_each_other(groups, every):
    t = abs(ttest_ind(every[1][0], every[0][0]).statistic)
    d = t * (1 / 4 + 1 / 4) ** 0.5
    for text, verdict in ((f"{d:.2f}", "possible"), (f"{d + 0.3:.2f}", "impossible")):
        both = PrintedTest(kind="independent_t", statistic=f"{t:.2f}", d=text)
        assert answer(both, groups[:2]).verdict == verdict
    f = f_oneway(*(rows[0] for rows in every)).statistic
    share = 2 * f / (2 * f + 8)
    for value, verdict in ((share, "possible"), (share + 0.1, "impossible")):
        both = PrintedTest(
            kind="one_way_f", statistic=f"{f:.2f}", partial_eta_squared=f"{value:.2f}"
        )
        assert answer(both, groups).verdict == verdict


def test_a_one_sided_p_is_half_of_the_two_sided_one(groups, every):
    found = ttest_ind(every[1][0], every[0][0])
    t, p = f"{abs(found.statistic):.2f}", found.pvalue
    for sides, value, verdict in (
        (2, p, "possible"),
        (1, p / 2, "possible"),
        (1, p, "impossible"),
        (2, p / 2, "impossible"),
    ):
        test = PrintedTest(kind="independent_t", statistic=t, p=f"{value:.3f}", sides=sides)
        assert answer(test, groups[:2]).verdict == verdict


def test_small_tables_are_answered_as_every_data_set_and_pairing_answers():
    counted, wrong = campaign(340, seed=7)
    assert not wrong
    undecided = sum(times for (verdict, _), times in counted.items() if verdict == "not decided")
    assert undecided <= 0.05 * 340
    assert counted["possible", True] > 50
    assert counted["impossible", False] > 50


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
            r"line 15, columns of item 1 of test: unknown column 'b'",
        ),
        (
            'statistic = "1.93"',
            "",
            "line 13, item 1 of test: expected a statistic, p, p_below",
        ),
        (
            'kind = "paired_t"',
            'kind = "t"',
            r"line 14, kind of item 1 of test: .*'independent_t'",
        ),
        ('statistic = "1.93"', 'p_below = "0"', "line 13, item 1 of test: p_below must be above 0"),
        ('["a", "column 2"]', '["a"]', "expected two or more different columns"),
        ('kind = "paired_t"', 'kind = "rm_f"\np = ".01"', "omit the p"),
        (
            'kind = "paired_t"',
            'kind = "rm_f"\nd = "1.0"',
            "d is an effect size for paired_t or independent_t",
        ),
        (
            'kind = "paired_t"',
            'kind = "paired_t"\npartial_eta_squared = "0.5"',
            "partial_eta_squared is an effect size for one_way_f or rm_f",
        ),
        ('kind = "paired_t"', 'kind = "rm_f"\nsides = 1', "omit sides"),
    ],
)
def test_a_wrong_test_is_refused_with_its_line(old, new, said):
    with pytest.raises(UserError, match=said):
        from_toml(TABLE.replace(old, new))


def test_a_test_of_two_columns_says_which(groups):
    with pytest.raises(UserError, match="expected the labels of the two columns"):
        answer(PrintedTest(kind="paired_t", statistic="1"), groups)


def test_a_random_part_of_the_choices_needs_no_memory_for_all(column):
    """The tables of Anscombe took 7 GB: all pairs of sums were multiplied, few were used."""
    rows = [
        ColumnRows(Solutions(column(11, mean, sd, maximum=2000)), sums_first=True)
        for mean, sd in (("900", "330.0"), ("750", "203.0"))
    ]
    pairs = len(rows[0].moments) * len(rows[1].moments)
    tracemalloc.start()
    found = cross_products.choices(rows)
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert not found.complete
    assert peak_bytes < 16 * pairs
