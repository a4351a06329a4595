"""The Monte Carlo errors of simulated studies, by number."""

import math

import numpy as np
import pytest
from scipy.stats import binomtest

from slipscale.analysis.planning.power.outcome import Share, Sums

VALUES = np.array([0.2, 0.5, np.nan, 0.9, 1.4, np.inf])


def test_a_share_has_the_binomial_s_error_and_wilson_s_interval():
    share = Share.of(20, 80)
    assert share.error == pytest.approx(math.sqrt(0.25 * 0.75 / 80))
    wilson = binomtest(20, 80).proportion_ci(0.95, method="wilson")
    assert (share.low, share.high) == pytest.approx((wilson.low, wilson.high), rel=1e-6)


def test_a_mean_has_the_sample_s_error_also_if_summed_in_parts():
    whole = VALUES[np.isfinite(VALUES)]
    for sums in (Sums.of(VALUES), Sums.of(VALUES[:2]) + Sums.of(VALUES[2:])):
        assert sums.mean == pytest.approx(whole.mean())
        assert sums.error == pytest.approx(whole.std(ddof=1) / math.sqrt(4))
    assert math.isnan(Sums.of(VALUES[:1]).error)
