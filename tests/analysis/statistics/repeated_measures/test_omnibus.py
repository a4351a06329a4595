"""Tests on estimates, against R (tests/data/r_reference) and closed forms; and their traps."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from statsmodels.regression.mixed_linear_model import MixedLM

from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.statistics import power_law
from slipscale.analysis.statistics.descriptives import cousineau_morey
from slipscale.analysis.statistics.mixed_model import mixed_model
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.reliability import reliability
from slipscale.analysis.statistics.repeated_measures import omnibus
from slipscale.analysis.statistics.repeated_measures.omnibus import friedman_of
from slipscale.analysis.statistics.repeated_measures.pairwise import pairwise, signed_rank_p
from slipscale.analysis.tasks.difference.proportions import exact_interval
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.analysis.tasks.estimation.growth.statistics import growth
from slipscale.analysis.tasks.estimation.order_effects import order_effects
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

HERE = Path(__file__).parents[3] / "data" / "r_reference"
R = json.loads((HERE / "reference.json").read_text())
AMPLITUDES = np.array([0, 0.5, 1.2, 2.3])


def ready(values, **choices):
    """Values, shape (participants, amplitudes) or (participants, amplitudes, repetitions)."""
    array = np.asarray(values, float)
    array = array[..., None] if array.ndim == 2 else array
    who, what, _ = np.indices(array.shape)
    frame = pd.DataFrame(
        {
            "participant_id": pd.Categorical([f"p{i:04d}" for i in who.ravel()]),
            "session": "",
            "run": "1",
            "level": AMPLITUDES[: array.shape[1]][what.ravel()],
            "normalised": array.ravel(),
        }
    ).dropna()
    return prepare(frame.reset_index(drop=True), AnalysisChoices(**choices))


@pytest.fixture(scope="module")
def reference():
    raw = pd.read_csv(HERE / "estimates.csv")
    frame = pd.DataFrame(
        {
            "participant_id": raw["participant"].astype("category"),
            "session": "",
            "run": "1",
            "level": raw["amp"],
            "normalised": raw["est"],
        }
    )
    return prepare(frame, AnalysisChoices())


def test_rm_anova_is_r_s_afex(reference):
    ours = omnibus.rm_anova(reference)
    for name in ("F", "df1", "df2", "epsilon_gg", "epsilon_hf", "eta2_generalised", "mauchly_w"):
        assert getattr(ours, name) == pytest.approx(R["anova"][name], rel=1e-9), name
    for name in ("p", "p_gg", "p_hf", "mauchly_p"):
        assert getattr(ours, name) == pytest.approx(R["anova"][name], rel=1e-6), name
    low, high = ours.eta2_generalised_interval
    assert low < ours.eta2_generalised < high


def test_friedman_is_r_s(reference):
    ours = omnibus.friedman(reference)
    assert ours.chi2 == pytest.approx(R["friedman"]["chi2"])
    assert ours.p == pytest.approx(R["friedman"]["p"])
    assert ours.kendalls_w == pytest.approx(34 / 36)


def test_holm_corrected_pairs_are_r_s(reference):
    rows = {(row.from_level, row.to_level): row for row in pairwise(reference)}
    # R lists the lower triangle by column: 0-0.5, 0-1.2, 0-2.3, 0.5-1.2, 0.5-2.3, 1.2-2.3.
    pairs = [(0, 0.5), (0, 1.2), (0, 2.3), (0.5, 1.2), (0.5, 2.3), (1.2, 2.3)]
    assert [rows[pair].logs.p_holm for pair in pairs] == pytest.approx(
        R["pairwise_t_holm"], rel=1e-6
    )
    raw = [signed_rank_p(_steps(reference, *pair)) for pair in pairs]
    assert raw == pytest.approx(R["wilcoxon_exact"])


def _steps(reference, low, high):
    logs = reference.whole_logs
    return (logs[high] - logs[low]).to_numpy()


def test_the_exponent_and_its_t_interval_are_r_s(reference):
    ours = power_law.power_law(reference)
    assert ours.exponent == pytest.approx(R["exponent"]["mean"])
    assert list(ours.interval) == pytest.approx(R["exponent"]["ci95"])
    assert ours.n == 12


def test_the_mixed_model_is_r_s_lme4_and_its_interval_is_student_s(reference):
    """statsmodels prints a normal interval, [.415, .610] here: too short for twelve people."""
    ours = mixed_model(reference)
    assert ours.intercept == pytest.approx(R["mixed"]["intercept"], rel=1e-4)
    assert ours.exponent == pytest.approx(R["mixed"]["slope"], rel=1e-4)
    assert ours.se == pytest.approx(R["mixed"]["se"][1], rel=1e-3)
    assert ours.log_likelihood_reml == pytest.approx(R["mixed"]["loglik_reml"], abs=1e-5)
    assert ours.sd_residual == pytest.approx(R["mixed"]["residual_sd"], rel=1e-3)
    assert list(ours.interval) == pytest.approx(R["exponent"]["ci95"], abs=2e-4)
    # Errors of variances are not usable (field notes): none is given.
    assert not any("se_" in name or "sd_intercept_se" in name for name in asdict(ours))


def test_in_balanced_data_the_mixed_model_s_exponent_is_the_mean_of_slopes(reference):
    slopes = power_law.exponents(reference.logs)["exponent"]
    assert mixed_model(reference).exponent == pytest.approx(slopes.mean(), rel=1e-5)


def test_a_third_optimiser_is_tried_only_if_two_disagree(reference, monkeypatch):
    used, fit = [], MixedLM.fit
    monkeypatch.setattr(MixedLM, "fit", lambda *a, **k: used.extend(k["method"]) or fit(*a, **k))
    assert mixed_model(reference).optimiser == used[0]
    rng = np.random.default_rng(1)
    slopes = (0.9 + 0.3 * rng.standard_normal((12, 1))) * np.log(AMPLITUDES[1:])
    logs = 3 + 0.5 * rng.standard_normal((12, 1)) + slopes + 0.1 * rng.standard_normal((12, 3))
    agreed = mixed_model(ready(np.exp(np.column_stack([np.full(12, 1.6), logs]))))
    assert agreed.converged
    assert used == ["bfgs", "lbfgs", "powell", "bfgs", "lbfgs"]


@pytest.mark.parametrize("seed", [0, 4])
def test_a_mixed_model_at_its_bound_converges_by_some_optimiser_and_says_so(seed):
    """Noise as large as the people's differences: no optimiser alone converges on both of these."""
    rng = np.random.default_rng(seed)
    logs = 3 + 0.3 * rng.standard_normal((12, 1)) + 0.9 * np.log(AMPLITUDES[1:])
    logs = logs + 0.25 * rng.standard_normal((12, 3))
    ready_made = ready(np.exp(np.column_stack([np.full(12, 1.6), logs])))
    found = mixed_model(ready_made)
    assert found.converged
    assert found.at_bound
    assert found.exponent == pytest.approx(power_law.power_law(ready_made).exponent, rel=1e-4)
    assert "is on the boundary of its range" in apa.mixed_model(found, 0.95, PLATE_AMPLITUDE)


def test_an_exponent_whose_fit_did_not_converge_is_not_put_in_a_sentence(reference):
    text = apa.mixed_model(replace(mixed_model(reference), converged=False), 0.95, PLATE_AMPLITUDE)
    assert "did not converge" in text
    assert not any(digit in text for digit in "0123456789")


def test_the_linear_trend_is_r_s(reference):
    ours = omnibus.linear_trend(reference).log_slope_per_level
    assert ours.mean == pytest.approx(R["trend"]["slope"])
    assert ours.t == pytest.approx(R["trend"]["t"])
    assert list(ours.interval) == pytest.approx(R["trend"]["ci95"])


def test_cousineau_morey_is_r_s_afex(reference):
    ours = cousineau_morey(reference.whole_logs.to_numpy())
    assert ours == pytest.approx(R["cousineau_morey_half_widths"])


def test_clopper_and_pearson_s_interval_is_r_s():
    assert list(exact_interval(17, 20)) == pytest.approx(R["clopper_pearson_17_of_20"])
    assert exact_interval(0, 12).low == 0
    assert exact_interval(12, 12).high == 1


@pytest.mark.parametrize("seed", range(4))
def test_the_signed_rank_p_with_ties_is_scipy_s(seed):
    steps = np.random.default_rng(seed).integers(-3, 6, 9).astype(float)
    expected = stats.wilcoxon(steps[steps != 0]).pvalue
    assert signed_rank_p(steps) == pytest.approx(expected)


def test_differences_that_are_equal_but_for_rounding_are_tied_or_zero():
    third = 0.1 + 0.2
    assert third not in (0.3, 0.0)
    rounded = signed_rank_p(np.array([0.3, third, -0.3, 0.6, third - 0.3]))
    assert rounded == pytest.approx(signed_rank_p(np.array([3.0, 3.0, -3.0, 6.0, 0.0])))


@pytest.mark.parametrize("n, method", [(50, "exact"), (51, "asymptotic")])
def test_the_signed_rank_p_is_exact_up_to_fifty_differences(n, method):
    steps = np.random.default_rng(n).permutation(np.arange(1.0, n + 1)) * np.resize([1, 1, -1], n)
    other = {"exact": "asymptotic", "asymptotic": "exact"}[method]
    assert signed_rank_p(steps) == pytest.approx(stats.wilcoxon(steps, method=method).pvalue)
    assert signed_rank_p(steps) != pytest.approx(stats.wilcoxon(steps, method=other).pvalue)


def test_the_signed_rank_p_with_ties_is_exact_up_to_thirteen_differences():
    """Of n equal differences, all up: 2 of 2^n signs are as extreme; asymptotically more."""
    assert signed_rank_p(np.ones(13)) == pytest.approx(2 / 2**13)
    asymptotic = stats.wilcoxon(np.ones(14), method="asymptotic").pvalue
    assert signed_rank_p(np.ones(14)) == pytest.approx(asymptotic)
    assert asymptotic != pytest.approx(2 / 2**14)


def test_constant_estimates_give_a_reason_and_not_a_silent_nan():
    data = ready(np.full((6, 4), 50.0))
    for test in (
        omnibus.rm_anova,
        omnibus.friedman,
        omnibus.page_trend,
        mixed_model,
        power_law.power_law,
        growth,
        reliability,
    ):
        assert isinstance(test(data), NotComputed), test.__name__
    assert isinstance(omnibus.linear_trend(data).log_slope_per_level, NotComputed)
    assert isinstance(order_effects(data), NotComputed)
    assert all(isinstance(pair.logs, NotComputed) for pair in pairwise(data))
    assert all(np.isnan(pair.ranks.p_holm) for pair in pairwise(data))


@pytest.mark.parametrize(
    "values,words",
    [
        (np.arange(8.0).reshape(2, 4) + 1, "every amplitude (2;"),
        (np.arange(5.0).reshape(5, 1) + 1, "amplitudes (1;"),
        (np.zeros((5, 4)), "amplitudes (0;"),
    ],
)
def test_too_little_data_gives_a_reason(values, words):
    assert words in omnibus.rm_anova(ready(values)).reason


def test_a_zero_takes_its_participant_out_of_logs_but_not_out_of_ranks():
    values = np.random.default_rng(5).lognormal(np.log([5, 20, 50, 80]), 0.3, (10, 4))
    values[0, 0] = 0
    data = ready(values)
    assert omnibus.rm_anova(data).n == 9
    assert omnibus.rm_anova(data).n_incomplete == 1
    assert omnibus.friedman(data).n == 10
    assert "Estimates of zero: 1" in data.zero_sentence


def test_half_minimum_keeps_the_participant_and_says_so():
    values = np.random.default_rng(5).lognormal(np.log([5, 20, 50, 80]), 0.3, (10, 4))
    smallest = values.min()
    values[0, 0] = 0
    data = ready(values, zero_rule="half_minimum")
    assert omnibus.rm_anova(data).n == 10
    expected = min(smallest, values[values > 0].min()) / 2
    assert f"{expected:.4g}" in data.zero_sentence


def test_refuse_computes_nothing_on_logarithms():
    values = np.random.default_rng(5).lognormal(3, 0.3, (10, 4))
    values[0, 0] = 0
    data = ready(values, zero_rule="refuse")
    assert "refuse" in omnibus.rm_anova(data).reason
    assert "refuse" in power_law.power_law(data).reason
    assert omnibus.friedman(data).n == 10


def test_the_anova_s_false_alarms_come_at_their_stated_rate():
    """400 studies without any effect: 5 % of p below .05, within four standard errors."""
    rng = np.random.default_rng(11)
    hits = 0
    for _ in range(400):
        values = rng.normal(size=(8, 4)) + rng.normal(size=(8, 1))
        residual = omnibus.additive_residuals(values)
        between = 8 * ((values.mean(0) - values.mean()) ** 2).sum() / 3
        f = between / ((residual**2).sum() / 21)
        hits += stats.f.sf(f, 3, 21) < 0.05
    assert abs(hits / 400 - 0.05) < 4 * np.sqrt(0.05 * 0.95 / 400)
    # The shortcut above is the same F as the one reported.
    assert pytest.approx(f) == omnibus.rm_anova(ready(np.exp(values))).F


def test_order_effects_are_recovered():
    """Each trial shifts the log estimate by 0.05 and each µm of the surface before by 0.1."""
    rng = np.random.default_rng(8)
    rows = []
    for person in range(30):
        before = np.nan
        for position, amplitude in enumerate(rng.permutation(np.repeat(AMPLITUDES, 4))):
            log = amplitude + 0.05 * position + 0.1 * np.nan_to_num(before)
            rows.append((f"p{person:02d}", amplitude, np.exp(log + rng.normal(0, 0.05))))
            before = amplitude
    frame = pd.DataFrame(rows, columns=["participant_id", "level", "normalised"])
    frame["participant_id"] = frame["participant_id"].astype("category")
    found = order_effects(prepare(frame.assign(session="", run="1"), AnalysisChoices()))
    assert found.log_slope_per_trial.mean == pytest.approx(0.05, abs=0.01)
    assert found.log_slope_per_trial.p < 0.001
    assert found.log_slope_per_level_before.mean == pytest.approx(0.1, abs=0.05)


def test_page_s_trend_is_one_sided(reference):
    assert omnibus.page_trend(reference).p < 1e-6
    backwards = ready(np.exp(-reference.whole_logs.to_numpy()))
    assert omnibus.page_trend(backwards).p > 0.999


@pytest.mark.parametrize("name", ["nm", "micropascal", "degrees"])
def test_the_mixed_model_is_lme4_s_whatever_the_stimulus_unit(name):
    """Without centring, log amplitudes far from 0 end short of the maximum, "converged"."""
    said = json.loads((HERE / "scales.json").read_text())[name]
    raw = pd.read_csv(HERE / "scales.csv").query("set == @name")
    frame = pd.DataFrame(
        {
            "participant_id": raw["participant"].astype(str).astype("category"),
            "session": "",
            "run": "1",
            "level": raw["x"].astype(float),
            "normalised": raw["y"],
        }
    )
    ours = mixed_model(prepare(frame.reset_index(drop=True), AnalysisChoices()))
    assert ours.converged
    assert ours.exponent == pytest.approx(said["exponent"], rel=1e-4)
    assert ours.log_likelihood_reml == pytest.approx(said["log_likelihood_reml"], abs=1e-3)
    for field in ("se", "sd_exponent", "sd_residual"):
        assert getattr(ours, field) == pytest.approx(said[field], rel=5e-3), field


def test_mauchly_is_not_defined_of_fewer_people_than_amplitudes_and_greenhouse_geisser_is_used():
    """W = 0, p > .999 and the uncorrected p were printed: errors of .17 to .20."""
    values = np.random.default_rng(1).lognormal(np.log([10, 20, 50, 80]), 0.4, (3, 4))
    found = omnibus.rm_anova(ready(values))
    assert found.mauchly_w is None
    assert found.mauchly_p is None
    text = apa.rm_anova(found, 0.95, PLATE_AMPLITUDE)
    assert "Greenhouse-Geisser" in text
    assert apa.p_value(found.p_gg) in text


def test_an_effect_is_judged_at_the_study_s_own_level():
    values = np.random.default_rng(8).lognormal(np.log([20, 26, 29]), 0.33, (9, 3))
    found = omnibus.rm_anova(ready(values))
    assert 0.01 < found.p_gg < 0.05
    assert "estimates differed" in apa.rm_anova(found, 0.95, PLATE_AMPLITUDE)
    assert "did not differ reliably" in apa.rm_anova(found, 0.99, PLATE_AMPLITUDE)


def test_a_p_is_never_printed_as_zero():
    from slipscale.analysis.reporting.latex import _p

    assert _p(0.0001) == "$<$.001"
    assert _p(0.0213) == ".021"
    assert _p(float("nan")) is None


@pytest.mark.parametrize("people", [3, 6, 12])
@pytest.mark.parametrize("spread", [1.0, 10.0])
def test_friedmans_error_rate_is_as_stated(people, spread):
    """Two to six percent; the F form is significant in 20 % with three people and conditions."""
    rng = np.random.default_rng(people)
    values = rng.normal(size=(1500, people, 3)) * np.array([1.0, 1.0, spread])
    found = [friedman_of(pd.DataFrame(each), 0) for each in values]
    chi2 = np.array([each.chi2 for each in found])
    ranks = (values.argsort(axis=2).argsort(axis=2) + 1).sum(axis=1)
    assert chi2 == pytest.approx(((ranks - 2 * people) ** 2).sum(axis=1) / people)
    share = np.mean([each.p < 0.05 for each in found])
    assert 0.01 < share < 0.08
    left = np.maximum(2 * people - chi2, 1e-9)
    by_f = stats.f.sf((people - 1) * chi2 / left, 2, 2 * (people - 1)) < 0.05
    assert bool(by_f.mean() > 0.15) == (people == 3)


def test_one_geometric_mean_is_singular():
    quantity = PLATE_AMPLITUDE
    one = pd.DataFrame({"geometric_mean": [12.0], "level": [1.2], "geometric_n": 6, "n": 6})
    assert apa.geometric_means(one, quantity) == (
        "The geometric mean of slipperiness was 12.00 at 1.2 µm."
    )
    two = pd.DataFrame(
        {"geometric_mean": [12.0, 20.0], "level": [1.2, 2.3], "geometric_n": [5, 6], "n": 6}
    )
    assert apa.geometric_means(two, quantity) == (
        "Geometric means of slipperiness were 12.00 at 1.2 µm (n = 5 of 6, without estimates of "
        "zero) and 20.00 at 2.3 µm."
    )
