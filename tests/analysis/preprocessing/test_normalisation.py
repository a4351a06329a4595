"""Normalisation rules: what each keeps, what each makes 100, and what Table III allows."""

from typing import get_args

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.analysis.load import load
from slipscale.analysis.preprocessing.normalisation import (
    RULES,
    cell_means,
    default_rule,
    log_cell_means,
    normalise,
    normalise_by_all,
)
from slipscale.analysis.published.biet2007 import ALLOWED_DATASET
from slipscale.experiments.study.analysis_choices import Normalisation
from slipscale.faults import UserError


def trials(values, scale_top=np.nan, modulus=np.nan):
    """Values, shape (participants, amplitudes, repetitions)."""
    array = np.asarray(values, float)
    who, what, _ = np.indices(array.shape)
    return pd.DataFrame(
        {
            "participant_id": pd.Categorical([f"p{i}" for i in who.ravel()]),
            "level": np.array([0, 0.5, 1.2, 2.3])[what.ravel()],
            "estimate": array.ravel(),
            "scale_top": scale_top,
            "modulus": modulus,
        }
    )


RANDOM = np.random.default_rng(3).lognormal(3, 1, (5, 4, 3))


def cells(data, rule):
    return cell_means(data.assign(normalised=normalise(data, rule)), "normalised").to_numpy()


def test_the_study_file_knows_exactly_the_rules_there_are():
    assert set(get_args(Normalisation)) == set(RULES)


@pytest.mark.parametrize("rule", sorted(RULES))
def test_every_rule_keeps_each_participant_s_ratios_and_zeros(rule):
    values = RANDOM.copy()
    values[0, 0] = 0
    data = trials(values, scale_top=200.0, modulus=20.0)
    ratio = (normalise(data, rule) / data["estimate"]).groupby(data["participant_id"])
    assert np.allclose(ratio.max(), ratio.min())
    assert (normalise(data, rule)[data["estimate"] == 0] == 0).all()


def test_each_rule_makes_100_what_it_says():
    data = trials(RANDOM, scale_top=200.0, modulus=20.0)
    assert cells(data, "grand_maximum").max() == pytest.approx(100)
    assert cells(data, "participant_maximum").max(axis=1) == pytest.approx(np.full(5, 100))
    assert cells(data, "top_stimulus")[:, 3] == pytest.approx(np.full(5, 100))
    assert normalise(data, "participant_largest_trial").max() == pytest.approx(100)
    assert np.allclose(normalise(data, "scale_top"), data["estimate"] / 2)
    assert np.allclose(normalise(data, "standard_referenced"), data["estimate"] * 5)


def test_modulus_equalisation_keeps_the_group_s_geometric_means():
    data = trials(RANDOM)
    equalised = data.assign(normalised=normalise(data, "modulus_equalisation"))
    before, after = log_cell_means(data), log_cell_means(equalised, "normalised")
    assert after.mean().to_numpy() == pytest.approx(before.mean().to_numpy())
    assert np.ptp(after.mean(axis=1)) == pytest.approx(0, abs=1e-12)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.01, 1000), st.sampled_from(["participant_maximum", "top_stimulus"]))
def test_a_participant_s_own_unit_does_not_matter(unit, rule):
    values = RANDOM.copy()
    values[1] *= unit
    assert cells(trials(values), rule) == pytest.approx(cells(trials(RANDOM), rule))


def test_the_default_is_the_declared_scale_top_where_all_have_one():
    assert default_rule(trials(RANDOM, scale_top=200.0)) == "scale_top"
    some = trials(RANDOM, scale_top=200.0)
    some.loc[some["participant_id"] == "p3", "scale_top"] = np.nan
    assert default_rule(some) == "grand_maximum"
    with pytest.raises(UserError, match=r"'scale_top' requires a declared top of.*for p3"):
        normalise(some, "scale_top")


def test_a_participant_of_zeros_has_no_maximum():
    values = RANDOM.copy()
    values[2] = 0
    with pytest.raises(UserError, match="missing for p2"):
        normalise(trials(values), "participant_maximum")
    assert "participant_maximum" not in normalise_by_all(trials(values))
    assert "grand_maximum" in normalise_by_all(trials(values))


def test_an_unknown_rule_is_refused_with_the_list():
    with pytest.raises(UserError, match="expected one of none, scale_top"):
        normalise(trials(RANDOM), "best")


def test_table_iii_cannot_come_from_each_participant_s_maximum():
    """The paper's mean at 2.3 µm is 81.33; the rule forces 100, as nobody had more below."""
    data = load(ALLOWED_DATASET).estimates
    assert cells(data, "participant_maximum")[:, 3].mean() == pytest.approx(100)
    assert cells(data, "grand_maximum")[:, 3].mean() == pytest.approx(81.33, abs=0.005)
