"""Psychometric functions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.protocol_parts.adaptive.curves import CURVES

FAMILIES = pytest.mark.parametrize("curve", CURVES.values(), ids=CURVES)


@FAMILIES
@given(share=st.floats(1e-6, 1 - 1e-6))
def test_the_inverse_leads_back(curve, share):
    assert curve.distribution(curve.inverse(np.array(share))) == pytest.approx(share, rel=1e-9)


@FAMILIES
@given(z=st.floats(-6, 3))
def test_the_density_is_the_slope(curve, z):
    step = 1e-5
    rise = curve.distribution(np.array(z + step)) - curve.distribution(np.array(z - step))
    assert curve.density(np.array(z)) == pytest.approx(rise / (2 * step), rel=1e-4, abs=1e-9)


@FAMILIES
@pytest.mark.parametrize("z", [-1e4, 1e4])
def test_far_away_the_asymptotes_are_reached_without_a_warning(curve, z):
    assert curve.distribution(np.array(z)) == (z > 0)
    assert curve.density(np.array(z)) < 1e-280


@FAMILIES
@given(level=st.floats(0.01, 5))
def test_levels_and_coordinates_are_each_others_inverse(curve, level):
    assert curve.level(curve.coordinate(level)) == pytest.approx(level)


def test_the_weibull_function_is_watsons():
    """Watson 2017, equation 1: 1 - lapse - (1 - guess - lapse) exp(-10**(b (x - t) / 20)), dB."""
    x_db, t_db, slope, guess, lapse = -18.0, -21.0, 3.5, 0.5, 0.02
    expected = 1 - lapse - (1 - guess - lapse) * np.exp(-(10 ** (slope * (x_db - t_db) / 20)))
    found = CURVES["weibull"].proportion(
        10 ** (x_db / 20), threshold_level=10 ** (t_db / 20), slope=slope, guess=guess, lapse=lapse
    )
    assert found == pytest.approx(expected)


def test_no_difference_is_answered_by_guessing():
    share = CURVES["weibull"].proportion(0.0, threshold_level=0.2, slope=3, guess=0.5, lapse=0.02)
    assert share == 0.5
