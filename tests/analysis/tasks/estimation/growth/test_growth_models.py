"""Which parameters the data determine: a limit of the search is named only if it is one."""

from __future__ import annotations

import numpy as np
import pytest

from slipscale.analysis.tasks.estimation.growth.growth_models import fit

STIMULI = np.array([0.5, 1.2, 2.3])


def estimates(function, seed=0, people=12, noise=0.1):
    random = np.random.default_rng(seed)
    return np.log(function(STIMULI)) + random.normal(0, noise, (people, 3))


@pytest.mark.parametrize("offset", [-0.3, 0.05, 0.5, 2.0])
def test_an_offset_that_the_data_determine_is_at_no_limit(offset):
    # The search goes from -0.5 to 2,300: a share of that range is no measure of nearness.
    found = fit("linear", STIMULI, estimates(lambda x: x + offset))
    assert found.parameters["offset"] == pytest.approx(offset, abs=0.3 + 0.1 * abs(offset))
    assert found.at_bound == ()


def test_a_doubling_stimulus_below_all_levels_is_not_determined():
    # Ekman's function only grows steeper. Data that grow less steep take the stimulus to its limit,
    # where the function is a power law.
    bent = estimates(lambda x: np.exp(0.9 * np.log(x) - 0.1 * np.log(x) ** 2), noise=0.02)
    assert fit("ekman", STIMULI, bent).at_bound == ("doubling_stimulus",)
