"""The peers' own public test cases, answered as they answer them.

scrutiny 0.6.1 (MIT), `tests/testthat`: GRIM, DEBIT and GRIMMER. closure-core 1.0.0 (MIT or
Apache 2.0), `src/count.rs`: counts. The numbers are facts of these tests; the code is ours.
"""

from __future__ import annotations

import pytest

from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.table_files import from_csv

T, F = True, False


@pytest.mark.parametrize(
    "means, n, step, percent, expected",
    [
        # test-grim.R: one item, three items, two items; whole percentages.
        ([f"5.{i}" for i in range(19, 31)], 28, "1", False, [F, F, T, F, F, F, T, F, F, F, T, F]),
        ([f"0.{i}" for i in range(150, 160)], 120, "1/3", False, [T, F, F, T, F, F, T, F, T, F]),
        ([f"0.{i}" for i in range(80, 90)], 28, "1/2", False, [T, F, T, F, T, F, T, T, T, T]),
        ([str(i) for i in range(519, 531)], 28, "1", True, [F, F, T, F, F, F, T, F, F, F, T, F]),
        ([str(i) for i in range(6, 17)], 50, "1", True, [T, F, T, F, T, F, T, F, T, F, T]),
    ],
    ids=["plain", "items 3", "items 2", "percent, 28", "percent, 50"],
)
def test_grim_as_scrutiny_answers(  # noqa: PLR0917 - a case each
    column, means, n, step, percent, expected
):
    found = []
    for mean in means:
        printed = {"mean_percent": mean} if percent else {}
        plain = None if percent else mean
        c = column(n, plain, None, maximum=10, step=step, **printed)
        found.append(Solutions(c).targets.grim)
    assert found == expected


def test_debit_as_scrutiny_answers():
    """test-debit-map.R: means and SDs of 1,683 zeros and ones."""
    table = "n,mean,sd,scale_maximum\n" + "".join(
        f"1683,{mean},{sd},1\n"
        for mean, sd in [
            ("0.53", "0.50"), ("0.44", "0.50"), ("0.77", "0.42"), ("0.19", "0.35"),
            ("0.34", "0.47"), ("0.93", "0.25"), ("0.12", "0.33"),
        ]
    )  # fmt: skip
    found = [Solutions(c).consistent for c in from_csv(table).columns]
    assert found == [T, T, T, F, T, T, T]


@pytest.mark.parametrize(
    "mean, sd, n, reason",
    [
        # test-grimmer-map.R
        ("7.22", "5.30", 38, "GRIM:"),
        ("4.74", "6.55", 31, ""),
        ("5.23", "2.55", 35, "GRIMMER:"),
        ("2.57", "2.57", 30, ""),
        ("6.77", "2.18", 33, "GRIM:"),
        ("2.68", "2.59", 34, ""),
        ("7.01", "6.68", 35, "GRIM:"),
        ("7.38", "3.65", 32, ""),
        ("3.14", "5.32", 33, "GRIM:"),
        ("6.89", "4.18", 37, ""),
        ("5.00", "2.18", 31, ""),
        ("0.24", "6.43", 34, ""),
        # test-grimmer.R, which compares with rsprite2 0.2.1
        ("5.21", "1.6", 28, ""),
        ("3.44", "2.47", 18, "GRIMMER:"),
    ],
)
def test_grimmer_without_a_scale_as_scrutiny_answers(mean, sd, n, reason):
    (c,) = from_csv(f"n,mean,sd\n{n},{mean},{sd}\n").columns
    assert Solutions(c).targets.reason.startswith(reason)
    assert bool(Solutions(c).targets.reason) == bool(reason)


@pytest.mark.parametrize(
    "facts, count",
    [
        # count.rs: test_count_single_solution, _all_same, _no_solutions, _with_rounding, _n2
        ((3, "2.0000000000", "1.0000000000", 1, 3), 1),
        ((4, "2.0000000000", "0.0000000000", 1, 3), 1),
        ((3, "1.5000000000", "0.5000000000", 1, 3), 0),
        ((4, "2", None, 1, 3), 11),
        ((2, "3.0000000000", "0.0000000000", 1, 5), 1),
        ((2, "3.0000000000", "1.4142135624", 1, 5), 1),
    ],
)
def test_counts_as_closure_core_counts(column, facts, count):
    n, mean, sd, low, high = facts
    assert Solutions(column(n, mean, sd, minimum=low, maximum=high)).multisets == count
