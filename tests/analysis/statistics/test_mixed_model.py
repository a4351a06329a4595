"""The search for a mixed model's maximum."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.statistics.mixed_model import likeliest


def conditions(seed):
    """Six people, three conditions, whose effects hardly differ between people."""
    rng, rows = np.random.default_rng(seed), []
    for who in range(6):
        own, slope = rng.normal(0, 0.3), 0.6 + rng.normal(0, 0.1)
        extra = rng.normal(0, 0.02, 3)
        for condition in range(3):
            for lx in np.log([0.5, 1, 2, 4]):
                ly = own + slope * lx + 0.2 * condition + extra[condition] + rng.normal(0, 0.15)
                rows.append((f"p{who}", f"c{condition}", lx, ly))
    return pd.DataFrame(rows, columns=["who", "condition", "lx", "ly"])


def test_where_no_search_converges_others_continue_to_the_maximum_of_lme4():
    """lmer(ly ~ lx * condition + (lx + condition | who)), lme4 in R 4.2: 18.32999114."""
    fit, _, _ = likeliest(conditions(6), "ly ~ lx * condition", "~ lx + condition")
    assert fit.converged
    assert float(fit.llf) == pytest.approx(18.32999114, abs=1e-3)
