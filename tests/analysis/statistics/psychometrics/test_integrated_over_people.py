"""Profiles end where the likelihood has two maxima, and the higher one is kept."""

import numpy as np
import pytest

from slipscale.analysis.statistics.psychometrics.integrated_over_people import (
    NO_EFFECT,
    Counted,
    IntegratedModel,
    Maximum,
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
