"""Frequencies, sums, percentages, SE, intervals and quartiles against complete enumeration."""

from __future__ import annotations

from fractions import Fraction
from math import sqrt

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.stats import t

from slipscale.analysis.reconstruction.data_sets.marginals import marginals
from slipscale.analysis.reconstruction.data_sets.saddle_point import log10_multisets
from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.data_sets.witness import gives_what_is_printed, witness
from slipscale.analysis.reconstruction.table.table_files import from_csv, from_toml
from slipscale.faults import UserError


@st.composite
def columns(draw):
    """Keyword arguments of a column made from ratings, so that it usually has solutions."""
    n, top = draw(st.integers(2, 6)), draw(st.integers(1, 5))
    x = sorted(draw(st.lists(st.integers(0, top), min_size=n, max_size=n)))
    places = draw(st.integers(0, 2))
    mean, sd = np.mean(x), np.std(x, ddof=1)
    half = t.ppf(0.975, n - 1) * sd / sqrt(n)
    quartiles = np.quantile(x, [0.25, 0.75], method=draw(st.sampled_from(["linear", "weibull"])))
    printed = {
        "mean": mean,
        "mean_percent": 100 * mean,
        "sum": sum(x),
        "sd": sd,
        "se": sd / sqrt(n),
        "lower_quartile": quartiles[0],
        "upper_quartile": quartiles[1],
        "median": np.median(x),
        "observed_maximum": x[-1],
    }
    kept = draw(st.sets(st.sampled_from(sorted(printed)))) | {
        draw(st.sampled_from(["mean", "sum"]))
    }
    facts = {name: f"{printed[name]:.{places}f}" for name in kept}
    if draw(st.booleans()):
        facts |= {"ci_low": f"{mean - half:.{places}f}", "ci_high": f"{mean + half:.{places}f}"}
    values = list(range(top + 1))
    told = draw(st.lists(st.sampled_from(values), unique=True, max_size=3))
    counts, shares, present, absent = [], [], [], []
    for value in told:
        kind = draw(st.sampled_from("fpsa"))
        if kind == "f":
            counts.append((value, x.count(value)))
        elif kind == "s":
            shares.append((value, f"{100 * x.count(value) / n:.{places}f}"))
        elif value in x:
            present.append(value)
        else:
            absent.append(value)
    return {
        "n": n,
        "maximum": top,
        "mean": None,
        "sd": None,
        "frequencies": counts,
        "percentages": shares,
        "present": present,
        "absent": absent,
        **facts,
    }


@settings(max_examples=50, deadline=None)
@example(
    facts={"n": 3, "maximum": 1, "mean": "0", "sd": None, "frequencies": [(0, 3)], "median": "0"}
)
@given(facts=columns())
def test_what_is_printed_leaves_what_enumeration_leaves(column, all_multisets, orders, facts):
    c = column(**facts)
    found = all_multisets(c)
    solutions = Solutions(c)
    assert solutions.multisets == len(found)
    assert solutions.ordered == sum(orders(x) for x in found)
    if found:
        assert sorted(map(tuple, solutions.listed.tolist())) == sorted(found)
        assert all(gives_what_is_printed(c, x) for x in found)


def test_the_definitions_refuse_what_enumeration_refuses(column, all_multisets):
    facts = {"mean": "2.4", "sd": None, "frequencies": [(2, 1)], "percentages": [(5, "20")]}
    loose = all_multisets(column(5, "2.4", None, maximum=5))
    right = column(5, maximum=5, present=(3,), absent=(0,), **facts)
    fit = [x for x in loose if gives_what_is_printed(right, x)]
    assert fit == all_multisets(right)
    assert 0 < len(fit) < len(loose)


@pytest.mark.parametrize(
    "sd, told",
    [
        ("0.8", {"absent": (Fraction(3, 2),)}),
        ("0.7", {"frequencies": [(2, 0), (Fraction(3, 2), 0)]}),
    ],
    ids=str,
)
def test_the_smallest_rating_may_be_one_of_several_that_somebody_gave(
    column, all_multisets, sd, told
):
    """Printed as 2, the smallest of ratings in halves is 1.5, 2 or 2.5."""
    facts = {"n": 5, "mean": "2.8", "sd": sd, "maximum": 4, "step": "1/2", "observed_minimum": "2"}
    found = all_multisets(column(**facts, **told))
    assert 0 < len(found) < len(all_multisets(column(**facts)))
    assert Solutions(column(**facts, **told)).multisets == len(found)


TOLD = {"frequencies": [(3, 2)], "absent": [5], "present": [2]}


def test_samples_and_marginals_hold_what_is_told(column, all_multisets):
    c = column(7, "3", "2", maximum=7, **TOLD)
    found = np.array(all_multisets(c))
    assert len(found) > 2
    for measure in ("multisets", "ordered"):
        drawn = Sampler(Solutions(c), measure).draw(500, np.random.default_rng(1))
        drawn_rows = {tuple(sorted(row)) for row in drawn.tolist()}
        assert drawn_rows <= set(map(tuple, found.tolist()))
        assert len(drawn_rows) > len(found) / 2
    exact = marginals(Solutions(c))
    assert exact.absent == tuple(int((found != v).all(axis=1).sum()) for v in range(8))
    for rank in range(1, 8):
        values, counts = np.unique(found[:, rank - 1], return_counts=True)
        expected = {
            int(v): Fraction(int(k), len(found)) for v, k in zip(values, counts, strict=True)
        }
        assert exact.order_statistic(rank) == expected


def test_samples_hold_the_quartiles(column, all_multisets):
    c = column(7, "3.14", "1.8", maximum=7, lower_quartile="2", upper_quartile="4.5")
    found = all_multisets(c)
    plain = Solutions(column(7, "3.14", "1.8", maximum=7))
    assert 1 < len(found) < plain.multisets
    for measure in ("multisets", "ordered"):
        drawn = Sampler(Solutions(c), measure).draw(2000, np.random.default_rng(1))
        assert {tuple(sorted(row)) for row in drawn.tolist()} <= set(found)


def test_quartiles_of_too_many_data_sets_are_refused(column):
    solutions = Solutions(column(30, "50.00", "10.00", lower_quartile="42"))
    assert "but 2,031," in solutions.refused


@pytest.mark.parametrize(
    "told", [{"absent": [50]}, {"frequencies": [(50, 3)]}, {"present": [50]}], ids=str
)
def test_an_estimate_and_a_witness_hold_what_is_told(column, told):
    solutions = Solutions(column(20, "50.00", "5.0", **told))
    ratio = 10 ** log10_multisets(solutions.targets) / solutions.multisets
    assert 1 / 1.1 < ratio < 1.1
    assert gives_what_is_printed(solutions.column, witness(solutions.column, solutions.targets))


def test_a_percentage_that_no_count_gives_is_a_finding(column):
    solutions = Solutions(column(30, "3.00", "1.00", maximum=6, percentages=[(2, "12.0")]))
    assert "GRIM: no count out of 30 gives 12.0 % for the rating 2" in solutions.reason


def test_numbers_for_one_mean_must_agree(column):
    assert Solutions(column(10, "2.4", None, sum="24", maximum=6)).consistent
    reason = Solutions(column(10, "2.4", None, sum="25", maximum=6)).reason
    assert "2.4 and 25, printed for the same mean, contradict each other" in reason


def test_a_standard_error_is_an_sd_over_the_root_of_n(column):
    by_se = Solutions(column(16, "3.00", None, se="0.258199", maximum=6))
    by_sd = Solutions(column(16, "3.00", "1.032796", maximum=6))
    assert by_se.multisets == by_sd.multisets > 0


PLAIN = """
[[column]]
n = 28
mean = "5.19"
sd = "1.50"
[[column]]
n = 18
mean = "3.44"
sd = "2.47"
[[column]]
n = 5
mean = "2.40"
sd = "1.14"
"""


def test_without_a_scale_grim_and_grimmer_and_the_sd_decide():
    grim, grimmer, fine = (Solutions(c) for c in from_toml(PLAIN).columns)
    assert "GRIM:" in grim.reason
    assert "GRIMMER:" in grimmer.reason
    assert not fine.column.scale_is_printed
    wide = from_toml(PLAIN + "[scale]\nminimum = -50\nmaximum = 50").columns[2]
    assert fine.multisets == Solutions(wide).multisets > 0


def test_columns_without_a_scale_are_on_one(column):
    first, second = from_csv("n,mean,sd\n5,2.40,1.14\n6,80.00,3.00\n").columns
    assert first.scale == second.scale
    assert Solutions(first).multisets == Solutions(column(5, "2.40", "1.14", minimum=-9)).multisets


def test_one_end_of_a_scale_is_enough():
    (c,) = from_csv("n,mean,sd,scale_minimum\n5,0.40,0.55,0\n").columns
    assert c.scale.minimum == 0
    assert c.scale_is_printed
    assert Solutions(c).multisets == 1


@pytest.mark.parametrize(
    "old, new, said",
    [
        (
            'mean = "5.19"',
            "",
            r"line 2, item 1 of column: expected a mean, a mean_percent",
        ),
        ('sd = "1.50"', "", r"line 2, item 1 of column: expected a scale .*, an sd or an se"),
        (
            'sd = "1.50"',
            'ci_low = "1"',
            "both ends of the confidence interval must be given together",
        ),
        (
            'sd = "1.50"',
            'sd = "1"\npresent = [3, 3]',
            "the rating 3 occurs 2 times in frequencies",
        ),
        ('sd = "1.50"', 'sd = "1"\nabsent = ["2.5"]', "the rating 5/2 is not on the scale"),
        (
            'sd = "1.50"',
            'sd = "1"\nfrequencies = {3 = -1}',
            "line 6, .*expected 0 or more, got -1",
        ),
        ('sd = "1.50"', 'sd = "1"\nfrequencies = {x = 1}', "such as 1, 0.5 or 1/3, got 'x'"),
    ],
)
def test_what_cannot_be_understood_is_told_with_its_line(old, new, said):
    with pytest.raises(UserError, match=said):
        from_toml(PLAIN.replace(old, new))


def test_a_cell_tells_of_several_ratings():
    header = "n,mean,sd,scale_maximum,present,absent,frequencies,percentages\n"
    (c,) = from_csv(header + "8,3.00,1.50,6,1 5,2,0:1 6:0,3:12.5\n").columns
    assert (list(c.present), list(c.absent)) == ([1, 5], [2])
    assert list(c.frequencies) == [(0, 1), (6, 0)]
    assert [(v, share.text) for v, share in c.percentages] == [(3, "12.5")]
