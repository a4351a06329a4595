"""The JSON form of results: keys as documented, and nothing that JSON cannot hold."""

import json

import numpy as np
import pytest

from slipscale.analysis.json_form import form, record, text
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import PowerLaw


def test_what_was_not_computed_is_its_reason():
    assert form(NotComputed("too few")) == {"reason": "too few"}


@pytest.mark.parametrize("value", [float("nan"), float("inf"), np.float64("-inf"), None])
def test_what_is_no_number_is_null(value):
    assert text({"value": value}) == '{\n  "value": null\n}\n'


def test_amplitudes_as_keys_are_written_as_short_as_they_are():
    assert form({0.0: 1, 0.5: np.int64(2), 2.3: True}) == {"0": 1, "0.5": 2, "2.3": True}


@pytest.mark.parametrize("confidence, key", [(0.95, "ci95"), (0.9, "ci")])
def test_only_an_interval_of_95_percent_is_called_so(confidence, key):
    interval = ConfidenceInterval(0.5, 0.7, confidence)
    keys = record(PowerLaw(exponent=0.6, interval=interval, sd=0.1, n=12, points=3))
    assert list(keys) == ["exponent", key, "sd", "n", "points"]
    assert keys[key] == [0.5, 0.7]


def test_what_is_no_result_is_refused():
    with pytest.raises(TypeError, match="set: not a result"):
        form({1, 2})


def test_inference_has_its_documented_keys_in_their_order(dataset):
    row = dataset.difference_row
    people = {f"{n:02d}": [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")] for n in range(1, 7)}
    # One in another order: of one order for all, effects of order are not computed.
    rows = {"01": dataset.default_estimates(1)[::-1]}
    found = json.loads(text(analyse(dataset(rows=rows, differences=people)).inference))
    assert " ".join(found) == (
        "friedman rm_anova pairwise page_trend linear_trend power_law mixed_model "
        "robust_exponent growth bayesian_growth order reliability normalisation sessions groups "
        "factors measured_coefficient difference thresholds exponent_and_weber scales matching "
        "ratings rating_conditions ratios "
        "productions similarity sorting same_different limits identification pointing"
    )
    assert " ".join(found["rm_anova"]) == (
        "scale F df1 df2 p epsilon_gg p_gg epsilon_hf p_hf eta2_generalised eta2_generalised_ci "
        "mauchly_w mauchly_p shapiro_w shapiro_p n n_incomplete "
        "levels left_out_levels"
    )
    assert " ".join(found["pairwise"][0]) == (
        "from_level to_level n n_logs ratio ratio_ci t df p d_z d_z_ci p_wilcoxon up down p_holm "
        "p_wilcoxon_holm equivalence_ratio equivalence_ci equivalence_p equivalence_p_holm "
        "bayes_factor_10"
    )
    assert " ".join(found["linear_trend"]) == "unit mean ci sd t df p n n_incomplete"
    assert " ".join(found["growth"]["friction"]) == "models best n exponent reduction shared_load"
    assert " ".join(found["growth"]["of_level"]["models"]["power"]) == (
        "parameters sd log_likelihood aic aicc bic points estimated at_bound delta_aicc weight"
    )
    assert found["order"]["position"]["unit"] == "natural logarithm per trial"
    assert " ".join(found["difference"]) == (
        "steps catch d_prime signal_detection psychometric weber thresholds verbal_reports "
        "finding participants answers_per_participant_and_step"
    )
    assert (
        found["difference"]["d_prime"] == found["difference"]["signal_detection"]["pooled_d_prime"]
    )
    assert " ".join(found["difference"]["catch"]) == "n yes ci95"
