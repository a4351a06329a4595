"""Effect sizes and their intervals: R, closed forms, coverage."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from slipscale.analysis.statistics.effect_sizes import (
    _sums,
    d_z_interval,
    eta2_interval,
    eta_squared_interval,
    hedges_g,
)

HERE = Path(__file__).parents[2] / "data" / "r_reference"
R = json.loads((HERE / "reference.json").read_text())


@pytest.fixture(scope="module")
def logs():
    raw = pd.read_csv(HERE / "estimates.csv")
    raw["log"] = np.log(raw["est"])
    return raw.groupby(["participant", "amp"])["log"].mean().to_numpy().reshape(12, 4)


def test_d_z_and_its_interval_are_r_s_effectsize(logs):
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    for (low, high), (d_z, *bounds) in zip(pairs, R["d_z"], strict=True):
        steps = logs[:, high] - logs[:, low]
        assert steps.mean() / steps.std(ddof=1) == pytest.approx(d_z)
        t = stats.ttest_1samp(steps, 0).statistic
        # effectsize searches by optim, to about a thousandth.
        assert list(d_z_interval(t, len(steps), 0.95)) == pytest.approx(bounds, rel=1e-3)


@given(t=st.floats(-30, 30), n=st.integers(3, 60), level=st.sampled_from([0.9, 0.95, 0.99]))
def test_the_interval_of_d_z_leaves_out_0_exactly_where_the_t_test_is_significant(t, n, level):
    low, high = d_z_interval(t, n, level)
    p = 2 * stats.t.sf(abs(t), n - 1)
    if abs(p - (1 - level)) > 1e-4:
        assert (low > 0 or high < 0) == (p < 1 - level)
    assert low < t / n**0.5 < high


def test_a_small_t_has_the_interval_of_the_distribution_itself():
    low, high = d_z_interval(0.0703125, 21, 0.99)
    for bound, p in ((low, 0.995), (high, 0.005)):
        assert stats.nct.cdf(0.0703125, 20, bound * 21**0.5) == pytest.approx(p, abs=1e-9)


def test_a_t_that_is_too_large_for_scipy_has_no_interval():
    assert d_z_interval(1e9, 12, 0.95) is None


def eta_squared(values):
    (effect,), (total,) = _sums(values - values.mean())
    return effect / total


def test_generalised_eta_squared_is_r_s_afex(logs):
    assert eta_squared(logs) == pytest.approx(R["anova"]["eta2_generalised"])


def test_leaving_out_each_participant_is_what_it_says(logs):
    effect, total = _sums(logs - logs.mean(), leave_out=True)
    brute = [eta_squared(np.delete(logs, i, axis=0)) for i in range(len(logs))]
    assert effect / total == pytest.approx(brute)


@pytest.mark.parametrize(
    "n, means, between, noise",
    [
        (12, [2.2, 2.7, 4.0, 4.4], 0.4, 0.4),
        (6, [2.2, 2.7, 4.0, 4.4], 0.4, 0.4),
        (12, [2.9, 3.0, 3.2, 3.4], 0.4, 0.3),
        (12, [2.2, 2.7, 4.0, 4.4], 0.4, [0.8, 0.6, 0.15, 0.12]),
    ],
    ids=["large", "six people", "small", "unequal spread"],
)
def test_the_interval_of_generalised_eta_squared_covers_about_as_stated(n, means, between, noise):
    """The percentile bootstrap covers 73 to 78 % in these cases."""
    spread = np.array(noise) * np.ones(4)
    middle, effect = np.array(means), np.var(means)
    truth = effect / (effect + between**2 + np.mean(spread**2))
    rng = np.random.default_rng(44)
    covered = 0
    for _ in range(1000):
        people, errors = rng.normal(0, between, (n, 1)), rng.normal(0, spread, (n, 4))
        low, high = eta_squared_interval(middle + people + errors, 0.95)
        covered += low <= truth <= high
    assert 920 <= covered <= 980


def test_without_variance_there_is_no_interval():
    assert eta_squared_interval(np.ones((5, 3)), 0.95) is None
    one_apart = np.ones((5, 3))
    one_apart[0] = [1, 2, 3]
    assert eta_squared_interval(one_apart, 0.95) is None


def test_differences_without_noise_have_no_interval_and_take_no_time():
    """SciPy's search took minutes at t = 1e8."""
    assert d_z_interval(1e8, 4, 0.95) is None


@settings(max_examples=40, deadline=None)
@given(st.floats(1e-6, 9e3), st.floats(0.9, 6), st.floats(2, 2000))
def test_the_interval_of_eta_squared_exists_for_every_f(f, df1, df2):
    """SciPy's non-central F is NaN at non-centralities far beyond the answer."""
    low, high = eta2_interval(f, df1, df2, 0.95)
    assert 0 <= low <= high <= 1
    # The ends are where F lies at either end of the confidence level.
    for end, p in ((low, 0.975), (high, 0.025)):
        if end > 0:
            shift = end / (1 - end) * (df1 + df2 + 1)
            assert stats.ncf.cdf(f, df1, df2, shift) == pytest.approx(p, abs=1e-6)


def test_hedges_g_covers_and_is_less_than_cohens_d():
    rng = np.random.default_rng(8)
    held = 0
    for _ in range(200):
        first, second = rng.normal(0.8, 1, 6), rng.normal(0, 1, 9)
        g, interval = hedges_g(first, second, 0.95)
        held += interval.low <= 0.8 <= interval.high
        pooled = ((5 * first.var(ddof=1) + 8 * second.var(ddof=1)) / 13) ** 0.5
        assert abs(g) < abs(first.mean() - second.mean()) / pooled
    assert held >= 180
