"""Lines of many participants at once: SciPy's, one by one."""

import numpy as np
import pytest
from scipy import stats

from slipscale.analysis.statistics.regression import fit_lines

X = np.log([0.5, 1.2, 2.3, 4.0])


def test_each_line_is_scipy_s_regression_of_the_points_there_are():
    y = np.random.default_rng(3).normal(size=(2, 5, 4))
    y[0, 1, 2] = y[1, 4, 0] = y[1, 0, 1] = y[1, 0, 2] = np.nan
    found = fit_lines(X, y)
    for place in np.ndindex(2, 5):
        there = ~np.isnan(y[place])
        line = stats.linregress(X[there], y[place][there])
        assert found.slope[place] == pytest.approx(line.slope)
        assert found.intercept[place] == pytest.approx(line.intercept)
        assert found.points[place] == there.sum()


def test_fewer_than_two_points_have_no_line():
    found = fit_lines(X, np.array([[1.0, np.nan, np.nan, np.nan], [np.nan] * 4]))
    assert np.isnan(found.slope).all()
    assert np.isnan(found.intercept).all()
    assert list(found.points) == [1, 0]
