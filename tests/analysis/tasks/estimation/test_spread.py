"""Unequal scatter within cells is a doubt; equal scatter is none."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.tasks.estimation.spread import unequal_spread
from slipscale.experiments.study.analysis_choices import AnalysisChoices


def study(spreads, people=12, repetitions=3):
    rng = np.random.default_rng(4)
    rows = [
        (f"{person}", amplitude, np.exp(amplitude + rng.normal(0, spread)))
        for person in range(people)
        for amplitude, spread in spreads.items()
        for _ in range(repetitions)
    ]
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "normalised"])
    frame["participant_id"] = frame["participant_id"].astype("category")
    return prepare(frame.assign(session="", run="1"), AnalysisChoices())


def test_unequal_scatter_is_a_doubt_with_its_ratio():
    (doubt,) = unequal_spread(study({0.5: 0.2, 1.2: 0.3, 2.3: 0.8}))
    assert "times as large at 2.3 µm as at 0.5 µm" in doubt
    ratio = float(doubt.split("estimates is ")[1].split(" times")[0])
    assert ratio == pytest.approx(4, abs=1)


def test_equal_scatter_and_single_estimates_are_none():
    assert unequal_spread(study({0.5: 0.3, 1.2: 0.3, 2.3: 0.3})) == []
    assert unequal_spread(study({0.5: 0.2, 2.3: 0.8}, repetitions=1)) == []
