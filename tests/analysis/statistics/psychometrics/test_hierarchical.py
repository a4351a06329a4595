"""The hierarchical psychometric model: as lme4 fits it, and true of simulated people."""

import json
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.population_thresholds import OBSERVERS, study
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.hierarchical import HierarchicalFit, Trials
from slipscale.analysis.statistics.psychometrics.integrated_over_people import students_fall
from slipscale.analysis.statistics.psychometrics.thresholds import model_of
from slipscale.analysis.tasks.thresholds.population_threshold import (
    population_threshold,
    population_weber,
)
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES
from slipscale.experiments.study.analysis_choices import AnalysisChoices

R = json.loads(
    (Path(__file__).parents[3] / "data" / "r_reference" / "psychometric.json").read_text()
)
TWO = model_of("two_interval", "weibull", 0.5, 0.2)


def of_r(columns):
    data = pd.DataFrame(R["data"])
    return Trials(
        person=data["person"].to_numpy(int) - 1,
        condition=np.zeros(len(data), int),
        design=np.stack([column(data) for column in columns], axis=1),
        u=data["level"].to_numpy(float),
        yes=data["yes"].to_numpy(float),
        n=data["n"].to_numpy(float),
    )


def ones(data):
    return np.ones(len(data))


def second_group(data):
    return (data["group"] == "b").to_numpy(float)


def test_without_guesses_and_lapses_it_is_the_mixed_model_of_lme4():
    model = model_of("comparison", "logistic", 0.5, 0.0)
    fit = HierarchicalFit(model, of_r([ones]), slopes_differ=False)
    equality = float(fit.coordinates(fit.best.theta[0]))
    assert equality == pytest.approx(R["equality"], rel=1e-4)
    assert np.exp(fit.best.theta[fit.slope]) / fit.scale == pytest.approx(R["slope"], rel=1e-3)
    assert fit.sd == pytest.approx(R["sd"], rel=2e-3)
    # lme4's are modes, ours means.
    assert equality + fit.deviations() == pytest.approx(R["persons"], abs=1e-3)


def test_a_groups_change_and_its_likelihood_are_those_of_lme4():
    model = model_of("comparison", "logistic", 0.5, 0.0)
    fit = HierarchicalFit(model, of_r([ones, second_group]), slopes_differ=False)
    assert fit.scale * fit.best.theta[1] == pytest.approx(R["group_change"], rel=1e-3)
    assert fit.fallen({1: 0.0}) == pytest.approx(R["log_likelihood_ratio_of_group"], rel=1e-3)


@pytest.mark.parametrize("method", ["two_interval", "yes_no", "comparison"])
def test_the_gradient_is_that_of_the_likelihoods_differences(method):
    rng = np.random.default_rng(1)
    trials, _ = study(rng, 4, 0.05, OBSERVERS["threshold: Weibull"])
    twice = Trials(
        person=np.tile(trials.person, 2),
        condition=np.repeat([0, 1], len(trials.person)),
        design=np.tile(trials.design, (2, 1)),
        u=np.tile(trials.u, 2),
        yes=np.concatenate([trials.yes, rng.permutation(trials.yes)]),
        n=np.tile(trials.n, 2),
        catch_right=9,
        catch_wrong=1,
    )
    model = HierarchicalFit(model_of(method, "weibull", 0.5, 0.2), twice)._fitted
    theta = np.array([0.1, 0.6, 0.4, 0.3, 0.2, 0.04, 0.3 if method == "yes_no" else 0.5])
    if method == "comparison":
        theta[-1] = 0.0
    numeric = [
        (model.minus_log(theta + step)[0] - model.minus_log(theta - step)[0]) / 2e-6
        for step in 1e-6 * np.eye(7)
    ]
    free = [*range(6), *([6] if method == "yes_no" else [])]
    assert model.minus_log(theta)[1][free] == pytest.approx(np.array(numeric)[free], rel=1e-4)


@pytest.mark.parametrize(
    "name,people,lapse", [("threshold: Weibull", 6, 0.05), ("equality: logistic", 6, 0.1)]
)
def test_the_populations_interval_holds_the_truth_and_lapses_leave_no_bias(name, people, lapse):
    """The campaign of 1,000 studies per cell is `benchmarks.population_thresholds`."""
    observer, held, found = OBSERVERS[name], 0, []
    model = model_of(observer.method, observer.fitted, 0.5, 0.2)
    for seed in range(24):
        answers, _ = study(np.random.default_rng(seed), people, lapse, observer)
        fit = HierarchicalFit(model, answers)
        truth = float(model.curve.coordinate(1.0) - fit.coordinates(np.array(0.0))) / fit.scale
        held += fit.fallen({0: truth}) <= students_fall(people, people - 1, 0.95)
        found.append(fit.coordinates(fit.best.theta[0]) - model.curve.coordinate(1.0))
    assert held >= 20
    assert abs(np.mean(found)) < 3 * np.std(found, ddof=1) / len(found) ** 0.5


@pytest.mark.parametrize("truth", [0.0, 0.6])
def test_slopes_that_differ_are_found_and_equal_ones_stay_equal(truth):
    rng, level = np.random.default_rng(5), np.linspace(-2.5, 2.5, 6)
    slopes = np.exp(rng.normal(0, truth, (16, 1)))
    p = CURVES["logistic"].distribution(slopes * (level - rng.normal(0, 0.8, (16, 1))))
    trials = Trials(
        person=np.repeat(np.arange(16), 6),
        condition=np.zeros(96, int),
        design=np.ones((96, 1)),
        u=np.tile(level, 16),
        yes=rng.binomial(30, p).astype(float).ravel(),
        n=np.full(96, 30.0),
    )
    model = model_of("comparison", "logistic", 0.5, 0.2)
    shared, own = (HierarchicalFit(model, trials, slopes_differ=differ) for differ in (False, True))
    gained = own.best.log_likelihood - shared.best.log_likelihood
    assert (gained > 10) == bool(truth)
    assert own.best.theta[own.unlike] == pytest.approx(truth, abs=0.2)
    assert np.exp(own.best.theta[own.slope]) / own.scale == pytest.approx(1.0, rel=0.2)


def test_catch_trials_tell_the_lapse_rate():
    trials, _ = study(np.random.default_rng(4), 6, 0.0, OBSERVERS["threshold: Weibull"])
    caught = {"catch_right": 450, "catch_wrong": 50}
    lapse = [
        HierarchicalFit(TWO, each).best.theta[-2]
        for each in (trials, Trials(**{**as_mapping(trials), **caught}))
    ]
    assert lapse[0] < 0.04
    assert lapse[1] > 0.05


def as_mapping(trials):
    return {name: getattr(trials, name) for name in Trials.__slots__}


def frame(people, *, seed=3, tau=0.2, curve="weibull", method="two_interval", sessions=("",)):
    """Return trials as read from a data set: {participant: (typical threshold, by session)}."""
    rng = np.random.default_rng(seed)
    rows = []
    for who, by_session in people.items():
        own = np.exp(rng.normal(0, tau))
        for session, typical in zip(sessions, by_session, strict=True):
            for level in np.repeat([0.3, 0.6, 1.0, 1.6, 2.6], 12):
                z = CURVES[curve].inverse(np.array(0.5)) + 2 * np.log(level / own / typical)
                p = 0.5 + 0.48 * float(CURVES[curve].distribution(z))
                rows.append((who, session, False, 1.2, level, bool(rng.random() < p)))
    names = ["participant_id", "session", "catch", "standard_level", "track_level", "correct"]
    return pd.DataFrame(rows, columns=names)


CHOICES = AnalysisChoices()


def test_groups_and_sessions_have_thresholds_and_the_change_between_them():
    people = {f"p{i:02d}": (1.0, 0.6) if i < 4 else (2.0, 1.2) for i in range(8)}
    groups = {who: "young" if first < 1.5 else "old" for who, (first, _) in people.items()}
    rows = frame(people, sessions=("1", "2"), tau=0.1)
    found = population_threshold(
        rows, CHOICES, method="two_interval", curve="weibull", group_of=groups
    )
    by_group, by_session = found.factors
    assert [(each.name, each.n) for each in by_group.levels] == [("old", 4), ("young", 4)]
    for factor, truth in ((by_group, 1 / 2.0), (by_session, 0.6)):
        (contrast,) = factor.contrasts
        low, high = contrast.change.interval
        assert low < truth < high
        assert contrast.change.value == pytest.approx(truth, rel=0.25)
        assert contrast.p < 0.05
    first, second = (each.threshold_level.value for each in by_session.levels)
    assert second / first == pytest.approx(by_session.contrasts[0].change.value, rel=0.02)


def test_equal_sessions_do_not_differ_and_people_vary_between_them():
    rows = frame({f"p{i}": (1.0, 1.0) for i in range(6)}, sessions=("1", "2"), seed=8)
    found = population_threshold(rows, CHOICES, method="two_interval", curve="weibull")
    (factor,) = found.factors
    (contrast,) = factor.contrasts
    assert contrast.p > 0.05
    assert contrast.change.interval.low < 1 < contrast.change.interval.high


def test_factors_shift_thresholds_and_one_is_averaged_over_the_other():
    rows = frame({f"p{i}": (1.0, 0.5) for i in range(3)}, sessions=("fast", "slow"), tau=0.1)
    side = np.where(np.arange(len(rows)) % 2, "left", "right")
    rows = rows.assign(session="").assign(
        **{"factor: speed": rows["session"], "factor: side": side}
    )
    found = population_threshold(rows, CHOICES, method="two_interval", curve="weibull")
    speed, sides, both = found.factors
    assert [each.name for each in found.factors] == ["speed", "side", "speed, side"]
    (slower,), (other,) = speed.contrasts, sides.contrasts
    assert slower.change.value == pytest.approx(0.5, rel=0.3)
    assert slower.p < 0.01 < other.p
    names = ["fast, left", "fast, right", "slow, left", "slow, right"]
    assert [each.name for each in both.levels] == names
    assert both.contrasts == ()
    logs = np.log([each.threshold_level.value for each in both.levels]).reshape(2, 2).mean(axis=1)
    by_speed = [np.log(each.threshold_level.value) for each in speed.levels]
    assert logs == pytest.approx(by_speed, abs=0.1)


def test_each_person_is_drawn_towards_the_population():
    found = population_threshold(
        frame({f"p{i}": (1.0,) for i in range(5)}), CHOICES, method="two_interval", curve="weibull"
    )
    logs = np.log(list(found.participants.values()))
    assert np.ptp(logs) < 1.0
    assert logs.mean() == pytest.approx(np.log(found.threshold_level.value), abs=0.05)
    assert found.n == 5
    assert found.answers == 300


def test_the_share_moves_the_threshold_along_the_curve():
    rows = frame({f"p{i}": (1.0,) for i in range(5)})
    at = {
        share: population_threshold(
            rows,
            AnalysisChoices(threshold_share=share),
            method="two_interval",
            curve="weibull",
        )
        for share in (0.5, 0.8)
    }
    moved = np.diff(CURVES["weibull"].inverse(np.array([0.5, 0.8])))[0] / at[0.5].slope.value
    ratio = at[0.8].threshold_level.value / at[0.5].threshold_level.value
    assert np.log(ratio) == pytest.approx(moved, rel=0.01)


def test_answers_that_fall_or_never_change_have_no_threshold():
    rows = frame({f"p{i}": (1.0,) for i in range(4)})
    falling = rows.assign(correct=rows["track_level"] < 1)
    found = population_threshold(falling, CHOICES, method="two_interval", curve="weibull")
    assert found == NotComputed("answers do not increase with the levels presented")
    alike = population_threshold(
        rows.assign(correct=True), CHOICES, method="two_interval", curve="weibull"
    )
    assert "all answers are the same" in alike.reason
    two = population_threshold(
        rows[rows["participant_id"] < "p2"], CHOICES, method="two_interval", curve="weibull"
    )
    assert two == NotComputed("too few participants (2; at least 3 are needed)")


@pytest.mark.parametrize("truth, other", [("log_normal", "normal"), ("normal", "log_normal")])
def test_a_comparison_on_the_wrong_axis_is_named_and_the_right_one_holds_the_truth(truth, other):
    """75 % of answers are "more" at 1.3 times the standard, or 0.3 above it."""
    rng, rows, levels = np.random.default_rng(2), [], [0.45, 0.65, 0.85, 1.15, 1.6, 2.3]
    half, z75 = (np.log(1.3) if truth == "log_normal" else 0.3), 0.6744897501960817
    for who, level in product([f"p{i}" for i in range(6)], np.repeat(levels, 60)):
        away = np.log(level) if truth == "log_normal" else level - 1
        more = bool(rng.random() < CURVES["normal"].distribution(np.array(z75 * away / half)))
        rows.append((who, "", False, 1.0, level, more))
    names = ["participant_id", "session", "catch", "standard_level", "track_level", "correct"]
    found = {
        curve: population_threshold(
            pd.DataFrame(rows, columns=names), CHOICES, method="comparison", curve=curve
        )
        for curve in (truth, other)
    }
    assert {curve: each.better_curve for curve, each in found.items()} == {truth: "", other: truth}
    fraction = population_weber(found[truth], "comparison", 1.0)
    expected = (1.3 - 1 / 1.3) / 2 if truth == "log_normal" else 0.3
    assert fraction.interval.low < expected < fraction.interval.high
    assert fraction.value == pytest.approx(expected, rel=0.1)


#: Correct answers of 20 in two intervals at levels 1 to 6, and the threshold within the population
#: by integration on a grid of 1,601 thresholds and 61 slopes.
MIXED = {
    "n1": ((8, 13, 19, 19, 20, 20), 2.335),
    "n2": ((10, 10, 19, 19, 19, 18), 2.472),
    "n3": ((13, 12, 17, 20, 19, 20), 2.747),
    "step": ((10, 10, 10, 20, 20, 20), 3.422),
    "perfect": ((20, 20, 20, 20, 20, 20), 0.623),
    "chance": ((11, 12, 10, 13, 9, 9), 9.859),
}


def answers_of(names):
    rows = [
        (who, "", False, np.nan, level, place < right)
        for who in names
        for level, right in enumerate(MIXED[who][0], start=1)
        for place in range(20)
    ]
    columns = ["participant_id", "session", "catch", "standard_level", "track_level", "correct"]
    return pd.DataFrame(rows, columns=columns)


def test_people_without_a_threshold_leave_that_of_the_others_between_their_own_and_the_typical():
    found = population_threshold(answers_of(MIXED), CHOICES, method="two_interval", curve="weibull")
    assert found.threshold_level.value == pytest.approx(2.616, rel=0.01)
    for who, (_, threshold) in MIXED.items():
        assert found.participants[who] == pytest.approx(threshold, rel=0.01), who


@pytest.mark.parametrize("names", list(combinations(MIXED, 4)), ids="-".join)
def test_every_mixture_of_people_is_that_of_plain_integration_on_a_fine_grid(names):
    """Weibull curves, two intervals; thresholds and slopes differ between people."""
    rows = answers_of(names)
    trials = Trials(
        person=pd.factorize(rows["participant_id"], sort=True)[0],
        condition=np.zeros(len(rows), int),
        design=np.ones((len(rows), 1)),
        u=np.log(rows["track_level"].to_numpy(float)),
        yes=rows["correct"].to_numpy(float),
        n=np.ones(len(rows)),
    )
    fit = HierarchicalFit(TWO, trials)
    fit.intervals(0, fit.slope, df=len(names) - 1, confidence=0.95)
    theta = fit.best.theta
    typical, steep = float(fit.coordinates(theta[0])), np.exp(theta[fit.slope]) / fit.scale
    normal = np.linspace(-6, 6, 2401)
    weights = np.exp(-(normal**2) / 2)
    b, d = np.meshgrid(normal, np.linspace(-3, 3, 7), indexing="ij")
    prior = weights[:, None] * np.exp(-(d**2) / 2)
    slope = steep * np.exp(theta[fit.unlike] * d)
    total, expected = 0.0, []
    for who in sorted(names):
        log_p = np.log(prior / prior.sum())
        for level, right in enumerate(MIXED[who][0], start=1):
            z = np.log(np.log(2)) + slope * (np.log(level) - typical - fit.sd * b)
            p = 0.5 + (0.5 - theta[fit.lapse]) * -np.expm1(-np.exp(np.minimum(z, 50)))
            log_p = (
                log_p + right * np.log(np.clip(p, 1e-12, 1)) + (20 - right) * np.log(1 - p + 1e-12)
            )
        top = log_p.max()
        share = np.exp(log_p - top)
        total += top + np.log(share.sum())
        expected.append(float((share * b).sum() / share.sum()) * fit.sd)
    assert fit.best.log_likelihood == pytest.approx(total, abs=0.15)
    assert fit.deviations() == pytest.approx(expected, abs=0.02)


def test_two_levels_have_no_population_curve():
    """Answers at 1 and 7 only had a point of equality of 5.32 [4.65, 6.47]."""
    rows = [
        (f"p{who}", "", False, 4.0, level, place < right)
        for who in range(6)
        for level, right in ((1.0, 1), (7.0, 11))
        for place in range(12)
    ]
    columns = ["participant_id", "session", "catch", "standard_level", "track_level", "correct"]
    found = population_threshold(
        pd.DataFrame(rows, columns=columns), CHOICES, method="comparison", curve="normal"
    )
    assert found == NotComputed("too few levels (2; at least 3 are needed)")
