"""Statistics against SciPy, statsmodels and Pingouin; pairings against every one of them."""

from __future__ import annotations

from itertools import permutations, product
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pingouin
import pytest
from scipy.stats import friedmanchisquare, linregress, ttest_rel
from statsmodels.stats.anova import AnovaRM

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.inference.distributions import distributions
from slipscale.analysis.reconstruction.inference.pairing import (
    at_random,
    least_alike,
    most_alike,
    searched,
)
from slipscale.analysis.reproduction.allowed_datasets import columns
from slipscale.analysis.statistics.repeated_measures import batched as statistics
from slipscale.faults import UserError

LOG_AMPLITUDE = tuple(np.log([0.5, 1.2, 2.3]))


@pytest.fixture
def tables():
    """Small ratings, so that there are ties and zeros."""
    return np.random.default_rng(4).integers(0, 9, (5, 7, 3)).astype(float)


def long(table):
    rows, k = table.shape
    return pd.DataFrame(
        {"p": np.repeat(range(rows), k), "c": list(range(k)) * rows, "y": table.ravel()}
    )


def test_f_and_epsilon_are_those_of_statsmodels_and_pingouin(tables):
    f, epsilon = statistics.repeated_measures_f(tables), statistics.greenhouse_geisser(tables)
    for i, table in enumerate(tables):
        fitted = AnovaRM(long(table), "y", "p", within=["c"]).fit().anova_table
        assert f[i] == pytest.approx(fitted["F Value"].iloc[0])
        expected = pingouin.epsilon(pd.DataFrame(table), correction="gg")
        assert epsilon[i] == pytest.approx(expected)


def test_friedman_and_t_are_those_of_scipy(tables):
    chi, t = statistics.friedman(tables), statistics.paired_t(tables[:, :, :2])
    for i, table in enumerate(tables):
        assert chi[i] == pytest.approx(friedmanchisquare(*table.T).statistic)
        assert t[i] == pytest.approx(ttest_rel(table[:, 1], table[:, 0]).statistic)


def test_an_exponent_is_the_slope_over_the_ratings_above_zero(tables):
    found = statistics.exponents(tables, LOG_AMPLITUDE)
    assert (tables == 0).any()
    for slope, row in zip(found.ravel(), tables.reshape(-1, 3), strict=True):
        kept = row > 0
        if kept.sum() < 2:
            assert np.isnan(slope)
        else:
            expected = linregress(np.array(LOG_AMPLITUDE)[kept], np.log(row[kept])).slope
            assert slope == pytest.approx(expected)
    assert statistics.mean_exponent(tables, LOG_AMPLITUDE) == pytest.approx(np.nanmean(found, 1))
    expected = np.nanstd(found, 1, ddof=1)
    assert statistics.sd_of_exponents(tables, LOG_AMPLITUDE) == pytest.approx(expected)


def test_no_error_left_is_an_infinite_f_and_no_differences_are_none():
    def shifted(*by):
        return np.add.outer(np.arange(4.0), by)[None]

    assert statistics.repeated_measures_f(shifted(0, 1, 2))[0] == np.inf
    assert statistics.repeated_measures_f(shifted(0, 0, 0))[0] == 0
    assert statistics.friedman(shifted(0, 0, 0))[0] == 0
    assert statistics.paired_t(shifted(1, 0))[0] == -np.inf


def every_pairing(table):
    """Every arrangement of a table's columns; the first can stay as it is."""
    orders = permutations(range(len(table)))
    first, *others = table.T
    return np.array(
        [
            np.stack([first, *(c[list(o)] for c, o in zip(others, chosen, strict=True))], axis=1)
            for chosen in product(list(orders), repeat=len(others))
        ]
    )


def test_no_pairing_has_a_larger_f_than_columns_in_the_same_order(tables):
    for table in tables[:, :4]:
        highest = statistics.repeated_measures_f(every_pairing(table)).max()
        found = statistics.repeated_measures_f(most_alike(table[None]))[0]
        assert found == pytest.approx(highest)


def test_no_pairing_of_two_columns_has_a_smaller_f_than_opposite_orders(tables):
    for table in tables[:, :6, :2]:
        lowest = statistics.repeated_measures_f(every_pairing(table)).min()
        found = statistics.repeated_measures_f(least_alike(table[None]))[0]
        assert found == pytest.approx(lowest)


def test_the_rearrangement_of_three_columns_comes_close_to_the_smallest_f(tables):
    # A heuristic: nearly always within a few per cent of the totals' smallest sum of squares.
    for table in tables[:, :4]:
        lowest = (every_pairing(table).sum(axis=2) ** 2).sum(axis=1).min()
        found = (least_alike(table[None]).sum(axis=2) ** 2).sum()
        assert lowest <= found <= 1.02 * lowest


@pytest.mark.parametrize("sign", [-1, 1])
def test_the_search_finds_the_extreme_friedman_of_most_small_tables(tables, sign):
    small = tables[:, :4]
    found = sign * statistics.friedman(
        searched(small, statistics.friedman, sign, np.random.default_rng(1))
    )
    best = np.array([(sign * statistics.friedman(every_pairing(t))).max() for t in small])
    assert (found <= best + 1e-9).all()
    assert np.isclose(found, best).mean() >= 0.8


@pytest.mark.parametrize(
    "arrange",
    [
        most_alike,
        least_alike,
        lambda t: at_random(t, np.random.default_rng(1)),
        lambda t: searched(t, statistics.friedman, 1, np.random.default_rng(1)),
    ],
    ids=["most", "least", "random", "searched"],
)
def test_a_pairing_keeps_every_columns_ratings(tables, arrange):
    assert (np.sort(arrange(tables), axis=1) == np.sort(tables, axis=1)).all()


@pytest.fixture(scope="module")
def table_3():
    found = distributions([Sampler(column) for column in columns()], seed=1, samples=60)
    quantiles = {(d.name, d.pairing): dict(d.quantiles) for d in found}
    significant = {(d.name, d.pairing): d.significant for d in found}
    return SimpleNamespace(found=found, quantiles=quantiles, significant=significant)


def test_every_statistic_rises_from_the_least_to_the_most_favourable_pairing(table_3):
    for name in {d.name for d in table_3.found}:
        low, middle, high = (
            table_3.quantiles[name, pairing][0.5]
            for pairing in ("least favourable", "random", "most favourable")
        )
        assert low <= middle + 1e-9 <= high + 2e-9, name


def test_samples_of_table_3_keep_to_its_bounds(table_3):
    """Over all data sets and pairings: F at least 88.36, t of 0 against 0.5 um 1.153 to 4.163."""
    assert table_3.quantiles["rm_f", "least favourable"][0.0] >= 88.36
    assert table_3.quantiles["t.0 um.0.5 um", "least favourable"][0.0] >= 1.1528
    assert table_3.quantiles["t.0 um.0.5 um", "most favourable"][1.0] <= 4.1630


def test_the_pairing_alone_decides_whether_0_and_0_5_um_differ(table_3):
    assert table_3.significant["t.0 um.0.5 um", "least favourable"] == 0
    assert table_3.significant["t.0 um.0.5 um", "most favourable"] == 1


def test_the_mean_exponent_of_table_3_does_not_depend_on_the_pairing(table_3):
    # No rating above 0 um can be zero, and slopes are linear in the logarithms.
    low, high = (
        table_3.quantiles["exponent.mean", f"{side} favourable"] for side in ("least", "most")
    )
    assert low == pytest.approx(high)


def test_the_same_seed_gives_the_same_distributions(column):
    samplers = [Sampler(Solutions(column(5, m, "1.52", maximum=9))) for m in ("2.60", "4.40")]
    first, second, other = (distributions(samplers, seed, 20) for seed in (1, 1, 2))
    assert first == second != other


def test_columns_of_different_participants_are_refused(column):
    samplers = [Sampler(Solutions(column(n, "2.4", "1.5", maximum=9))) for n in (5, 10)]
    with pytest.raises(UserError, match="differ in n or scale"):
        distributions(samplers)
    with pytest.raises(UserError, match="two or more"):
        distributions(samplers[:1])
