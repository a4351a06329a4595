"""Profiles end where the likelihood has two maxima, and the higher one is kept."""

import numpy as np
import pytest

from slipscale.analysis.statistics.psychometrics.integrated_over_people import (
    NO_EFFECT,
    Counted,
    IntegratedModel,
    Maximum,
    Prediction,
)


class TwoPeaks(IntegratedModel):
    """A parabola around 2, which only a search with a held parameter reaches; 1 is a lower peak."""

    def fit(self, start, held=None):  # noqa: ARG002 - as it is called
        if not held:
            return Maximum(np.array([1.0]), -1.0, np.zeros(1))
        at = held[0]
        return Maximum(np.array([at]), -((at - 2.0) ** 2) / 2, np.array([2.0 - at]))


def test_a_profile_ends_though_the_free_search_returns_to_the_lower_maximum():
    one = np.ones((1, 1))
    counted = Counted(yes=one, no=one, cells=np.zeros(1, int), times=np.ones(1))
    model = TwoPeaks(counted, None, [(-20.0, 20.0)], spreads=(), outer=NO_EFFECT)
    best = model.fit(np.zeros(1))
    _, (found,) = model.profiles(best, [0], fall=2.0)
    # The profile is taken from the highest point met: an end lies where it has fallen by 2.
    top = -((found.value - 2.0) ** 2) / 2
    assert top > best.log_likelihood + 0.4
    for end in (found.low, found.high):
        assert -((end - 2.0) ** 2) / 2 == pytest.approx(top - 2.0, abs=1e-3)


@pytest.mark.parametrize("checked", [True, False])
def test_a_maximum_that_a_finer_grid_does_not_confirm_is_an_error_of_the_integral(checked):
    # The log likelihood is -θ² / 2; the coarse grid adds a narrow peak at the interval's end.
    def predict(theta, outer, inner):
        (x,) = theta
        peak = 6 * np.exp(-50 * (x - 2) ** 2)
        value = np.full((1, 1, 1), -(x**2) / 2 + peak)
        slope = -x - 100 * (x - 2) * peak
        return Prediction(value, np.zeros_like(value), lambda yes, _: np.array([slope * yes.sum()]))

    one = np.ones((1, 1))
    counted = Counted(yes=one, no=0 * one, cells=np.zeros(1, int), times=np.ones(1))
    model = IntegratedModel(
        counted,
        predict,
        [(-5.0, 5.0)],
        spreads=(),
        outer=NO_EFFECT,
        finer=(lambda theta: -(theta[0] ** 2) / 2) if checked else None,
    )
    best = model.fit(np.array([0.1]))
    _, ((value, low, high),) = model.profiles(best, (0,), 2.0)
    if checked:
        assert value == pytest.approx(0, abs=1e-3)
        assert low == pytest.approx(-2, abs=0.01)
        assert 2 < high < 2.6
    else:
        assert value == pytest.approx(2, abs=0.05)
