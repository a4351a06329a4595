"""t-based intervals have n - 1 degrees of freedom; the quantiles are those of printed tables."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.statistics.descriptives import cousineau_morey, student_intervals
from slipscale.analysis.statistics.effect_sizes import eta_squared, eta_squared_interval
from slipscale.analysis.statistics.equivalence import equivalence
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.tasks.estimation.jackknife import jackknife

# Two-sided 95 % quantiles by number of participants: Student's t with n - 1 degrees of freedom.
T95 = {3: 4.302653, 4: 3.182446, 6: 2.570582, 12: 2.200985, 30: 2.045230}
T90 = {3: 2.919986, 4: 2.353363, 6: 2.015048, 12: 1.795885, 30: 1.699127}


@pytest.fixture(params=T95)
def values(request):
    return np.random.default_rng(request.param).normal(3.0, 1.0, (request.param, 4))


def standard_errors(values):
    return np.sqrt(((values - values.mean(0)) ** 2).sum(0) / (len(values) - 1) / len(values))


def test_an_interval_of_a_mean(values):
    expected = T95[len(values)] * standard_errors(values)
    low, high = student_intervals(pd.DataFrame(values), 0.95)
    assert (high - low) / 2 == pytest.approx(expected, rel=1e-6)
    found = mean_over_participants(values[:, 0], 0.95)
    assert (found.interval.high - found.interval.low) / 2 == pytest.approx(expected[0], rel=1e-6)
    assert found.df == len(values) - 1


def test_a_within_participant_interval(values):
    shifted = values - values.mean(1, keepdims=True)
    expected = T95[len(values)] * np.sqrt(4 / 3) * standard_errors(shifted)
    assert cousineau_morey(values) == pytest.approx(expected, rel=1e-6)


def test_a_jackknife_interval_of_a_mean_is_the_interval_of_the_mean(values):
    one = values[:, 0]
    without = (one.sum() - one) / (len(one) - 1)
    found = jackknife(float(one.mean()), without, confidence=0.95)
    expected = T95[len(one)] * standard_errors(values)[0]
    assert (found.interval.high - found.interval.low) / 2 == pytest.approx(expected, rel=1e-6)
    plain = mean_over_participants(one, 0.95)
    assert found.df == len(one) - 1
    assert (found.t, found.p, found.sd) == pytest.approx((plain.t, plain.p, plain.sd))


def test_an_equivalence_interval_leaves_alpha_in_each_tail(values):
    found = equivalence(mean_over_participants(values[:, 0], 0.95), 1.2)
    width = np.log(found.interval.high / found.interval.low) / 2
    assert width == pytest.approx(T90[len(values)] * standard_errors(values)[0], rel=1e-6)


def test_the_interval_of_an_effect_size(values):
    """A jackknife of artanh η, written out."""
    n = len(values)
    z = [np.arctanh(np.sqrt(eta_squared(np.delete(values, i, 0)))) for i in range(n)]
    pseudo = n * np.arctanh(np.sqrt(eta_squared(values))) - (n - 1) * np.array(z)
    half = T95[n] * pseudo.std(ddof=1) / np.sqrt(n)
    expected = [np.tanh(max(pseudo.mean() + sign * half, 0.0)) ** 2 for sign in (-1, 1)]
    assert tuple(eta_squared_interval(values, 0.95)) == pytest.approx(expected, rel=1e-5)
