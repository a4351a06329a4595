"""Slopes per participant agree with ordinary least squares."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as smf

from slipscale.analysis.preprocessing.residuals import slopes_per_participant


@pytest.mark.parametrize("parts", [False, True])
def test_slope_and_p_are_those_of_a_regression_with_a_mean_for_each_part(parts):
    rng = np.random.default_rng(1)
    who, part = np.repeat([0, 1], [14, 9]), np.array([0] * 6 + [1] * 8 + [0] * 4 + [2] * 5)
    x = rng.normal(size=23)
    y = 0.3 * x + 2.0 * part + rng.normal(size=23)
    slopes, p = slopes_per_participant(who, x, y, 3, part if parts else None)
    for person in (0, 1):
        own = pd.DataFrame({"x": x, "y": y, "part": part})[who == person]
        fit = smf.ols("y ~ x + C(part)" if parts else "y ~ x", own).fit()
        assert slopes[person] == pytest.approx(fit.params["x"])
        assert p[person] == pytest.approx(fit.pvalues["x"])
    assert np.isnan(slopes[2])
