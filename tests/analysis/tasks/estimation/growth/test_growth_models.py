"""Which parameters the data determine: a limit of the search is named only if it is one."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation.growth.growth_models import compare, fit
from slipscale.analysis.tasks.estimation.growth_section import _models
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

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


def test_growth_functions_are_not_compared_if_estimates_fall():
    # The threshold model fitted such data best, with both parameters at the limits of the search.
    falling = pd.DataFrame(estimates(lambda x: x**-1.3), columns=STIMULI)
    assert compare(falling) == NotComputed(
        "estimates decrease as amplitude increases, but growth functions can only increase"
    )
    assert compare(-falling).best in {"power", "ekman", "threshold"}


def test_the_table_shows_no_value_for_a_parameter_at_a_limit():
    bent = estimates(lambda x: np.exp(0.9 * np.log(x) - 0.1 * np.log(x) ** 2), noise=0.02)
    table = str(_models(compare(pd.DataFrame(bent, columns=STIMULI)), PLATE_AMPLITUDE))
    assert "doubling stimulus not determined" in table
    assert "half saturation not determined" not in table
