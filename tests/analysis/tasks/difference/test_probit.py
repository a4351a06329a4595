"""d' by step size, and shares of clustered answers: that intervals hold what they promise."""

from math import inf, isfinite

import numpy as np
import pytest
from scipy.stats import norm, ttest_1samp

from slipscale.analysis.json_form import record
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.psychometrics.integrated_over_people import (
    Counted,
    IntegratedModel,
    Prediction,
    even,
    students_fall,
)
from slipscale.analysis.tasks.difference.probit import DPrimeOfSize, _Probit, d_primes
from slipscale.analysis.tasks.difference.proportions import clustered_interval, exact_interval
from slipscale.analysis.tasks.difference.sentences import sensitivity
from slipscale.analysis.tasks.difference.yes_no import (
    Sensitivity,
    SignalDetection,
    _mean_of_own,
)
from slipscale.stimuli.quantity import PLATE_AMPLITUDE


def answers(rng, people, steps, catches, d):
    """Return sizes, answers, people of equal-variance observers with criteria of their own."""
    who = np.repeat(np.arange(people), steps + catches)
    sizes = np.tile([1.0] * steps + [0.0] * catches, people)
    criterion = rng.normal(0.8, 0.4, people)
    yes = rng.random(len(who)) < norm.cdf(d * (sizes > 0) - criterion[who])
    return sizes, yes.astype(float), who


def interval_of(data):
    sizes, felt, who = data
    return d_primes(sizes, felt, who, 0.95)[0].interval


def test_the_interval_covers_people_whose_sensitivities_differ():
    """With the criterion alone differing, 13 of these 20 intervals hold the truth."""
    found = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        who = np.repeat(np.arange(10), 40)
        sizes = np.tile(np.repeat([0.0, 1.0], 20), 10)
        centre = rng.normal(2.0, 1.0, 10)[who] * sizes - rng.normal(0.8, 0.2, 10)[who]
        felt = rng.random(len(who)) < norm.cdf(centre)
        found.append(interval_of((sizes, felt.astype(float), who)))
    assert sum(low <= 2.0 <= high for low, high in found) >= 18


def test_the_gradient_of_the_integrated_likelihood_is_that_of_its_differences():
    rng = np.random.default_rng(2)
    yes, no = rng.integers(0, 5, (2, 4, 3)).astype(float)
    counted = Counted(yes=yes, no=no, cells=np.array([0, 1, 1]), times=np.array([1.0, 2, 1, 1]))
    bounds = [(-8, 8)] * 3 + [(0, 4)] * 2
    model = IntegratedModel(
        counted, _Probit(3), bounds, spreads=(3, 4), outer=even(21), inner=even(11)
    )
    theta = np.array([0.8, 1.5, 0.4, 0.7, 0.5])
    steps = 1e-5 * np.eye(5)
    differences = [
        (model.minus_log(theta + step)[0] - model.minus_log(theta - step)[0]) / 2e-5
        for step in steps
    ]
    assert model.minus_log(theta)[1] == pytest.approx(differences, abs=1e-6)


def test_the_ends_of_a_profile_of_normal_data_are_students():
    """Of 10,000 answers each, people's own levels are known: Student's interval of them."""
    levels = norm.ppf([0.3, 0.45, 0.6, 0.8, 0.55])
    n = 10_000.0
    yes = n * norm.cdf(levels)[:, None]
    counted = Counted(yes=yes, no=n - yes, cells=np.zeros(1, int), times=np.ones(5))

    def predict(theta, outer, inner):
        z = (theta[0] + theta[1] * outer[0])[None] + 0 * inner
        log_yes, log_no = norm.logcdf(z), norm.logcdf(-z)

        def gradient(pull_yes, pull_no):
            slope = np.exp(norm.logpdf(z) - log_yes) * pull_yes
            slope -= np.exp(norm.logpdf(z) - log_no) * pull_no
            return np.array([slope.sum(), (slope * outer[0]).sum()])

        return Prediction(log_yes, log_no, gradient)

    model = IntegratedModel(counted, predict, [(-3, 3), (0, 2)], spreads=(1,), outer=even(1_001))
    best = model.fit(np.array([0.1, 0.5]))
    _, (found,) = model.profiles(best, [0], students_fall(5, 4, 0.95))
    student = ttest_1samp(levels, 0).confidence_interval(0.95)
    assert found.value == pytest.approx(levels.mean(), abs=2e-4)
    assert (found.low, found.high) == pytest.approx((student.low, student.high), abs=2e-3)


@pytest.mark.parametrize("d", [1.0, 2.0, 3.0])
def test_with_three_steps_and_one_catch_the_interval_covers(d):
    """The interval of the mean of participants' d' covers .002 at d' = 2 here, .000 at 3."""
    rng = np.random.default_rng(int(d))
    found = [interval_of(answers(rng, 12, 3, 1, d)) for _ in range(40)]
    assert sum(low <= d <= high for low, high in found) >= 35


def test_a_known_d_prime_is_recovered_for_each_size_of_step():
    rng = np.random.default_rng(3)
    who = np.repeat(np.arange(60), 60)
    sizes = np.tile(np.repeat([0.0, 0.5, 1.1], 20), 60)
    truth = {0.0: 0.0, 0.5: 0.8, 1.1: 1.9}
    centre = np.array([truth[size] for size in sizes]) - rng.normal(0.5, 0.3, 60)[who]
    felt = (rng.random(len(who)) < norm.cdf(centre)).astype(float)
    found = d_primes(sizes, felt, who, 0.95)
    assert [each.removed_level for each in found] == [0.5, 1.1]
    assert [each.d_prime for each in found] == pytest.approx([0.8, 1.9], abs=0.12)


def test_where_every_step_was_felt_there_is_a_lower_bound_only():
    who = np.repeat(np.arange(8), 4)
    sizes = np.tile([1.0, 1.0, 1.0, 0.0], 8)
    found = d_primes(sizes, (sizes > 0).astype(float), who, 0.95)[0]
    assert found.at_ceiling
    assert found.d_prime is None
    assert found.interval.high == inf
    assert 1 < found.interval.low < 5
    assert record(found)["ci95"] == [found.interval.low, None]


def test_where_no_step_was_felt_there_is_an_upper_bound_only_and_no_ceiling():
    who = np.repeat(np.arange(8), 4)
    sizes = np.tile([1.0, 1.0, 1.0, 0.0], 8)
    found = d_primes(sizes, (sizes == 0).astype(float), who, 0.95)[0]
    assert found.interval.low == -inf
    assert isfinite(found.interval.high)
    assert not found.at_ceiling


@pytest.mark.parametrize("felt,told", [(1.0, "all of"), (0.0, "none of")])
def test_answers_that_are_always_the_same_determine_no_sensitivity(felt, told):
    who = np.repeat(np.arange(6), 4)
    sizes = np.tile([1.0, 1.0, 1.0, 0.0], 6)
    by_size = d_primes(sizes, np.full(24, felt), who, 0.95)
    assert (*by_size[0].interval, by_size[0].d_prime) == (-inf, inf, None)
    assert not by_size[0].at_ceiling
    pooled = Sensitivity(
        hits=int(18 * felt), changes=18, false_alarms=int(6 * felt), catches=6,
        d_prime=0.0, criterion=0.0,
    )  # fmt: skip
    found = SignalDetection(
        pooled=pooled,
        by_size=by_size,
        all_sizes=by_size[0],
        mean_d_prime=NotComputed("not of interest here"),
        participants={},
    )
    said = sensitivity(found, 0.95, PLATE_AMPLITUDE)
    assert said.startswith(
        f"Sensitivity was undetermined ({told} these answers and the answers to catch steps w"
    )
    assert said.endswith("“yes”) for steps of 1 µm.")


def test_two_people_or_no_catch_steps_give_no_d_prime():
    sizes, felt, who = answers(np.random.default_rng(1), 2, 3, 1, 1.0)
    assert "too few participants (2;" in d_primes(sizes, felt, who, 0.95).reason
    assert "no catch" in d_primes(np.ones(9), np.ones(9), np.repeat(np.arange(3), 3), 0.95).reason


def test_there_is_no_mean_of_individual_d_primes_of_a_few_trials():
    def own(steps):
        return Sensitivity(
            hits=2, changes=steps, false_alarms=1, catches=steps, d_prime=1.0, criterion=0.0
        )

    few = _mean_of_own({str(n): own(19) for n in range(5)}, 0.95)
    assert isinstance(few, NotComputed)
    assert "at least 20" in few.reason
    assert "at least 20" not in _mean_of_own({str(n): own(20) for n in range(5)}, 0.95).reason


@pytest.mark.parametrize("people,repeats,alike", [(6, 10, 0.3), (12, 10, 0.6), (30, 3, 0.3)])
def test_the_interval_of_a_share_covers_where_a_participant_s_answers_are_alike(
    people, repeats, alike
):
    """Clopper and Pearson's over all answers covers some .58 to .86 of these."""
    rng = np.random.default_rng(people)
    p = 0.5
    a = p * (1 - alike) / alike
    covered = 0
    for _ in range(300):
        own = rng.beta(a, a, people)
        yes = rng.binomial(repeats, own).astype(float)
        low, high = clustered_interval(yes, np.full(people, float(repeats)))
        covered += low <= p <= high
    assert covered >= 0.92 * 300


def test_one_answer_a_participant_is_clopper_and_pearson_s_own_interval():
    yes = np.array([1.0, 0, 1, 1, 0, 1])
    assert clustered_interval(yes, np.ones(6)) == exact_interval(4, 6)


def test_answers_all_alike_count_as_one_a_participant():
    low, high = clustered_interval(np.full(5, 10.0), np.full(5, 10.0))
    assert (low, high) == pytest.approx((0.025 ** (1 / 5), 1.0))
    assert list(clustered_interval(np.array([3.0]), np.array([4.0]))) == [0, 1]
    assert isfinite(low)


def test_sizes_with_the_same_bound_share_one_clause():
    def size(um, d_prime, low, high):
        limits = ConfidenceInterval(low=low, high=high)
        return DPrimeOfSize(removed_level=um, steps=9, yes=9, d_prime=d_prime, interval=limits)

    found = SignalDetection(
        pooled=Sensitivity(
            hits=9, changes=9, false_alarms=1, catches=9, d_prime=1.0, criterion=0.0
        ),
        by_size=(size(0.5, 1.2, 0.4, 2.0), size(0.7, None, 1.76, inf), size(1.1, None, 1.76, inf)),
        all_sizes=NotComputed("not of interest here"),
        mean_d_prime=NotComputed("not of interest here"),
        participants={},
    )
    assert sensitivity(found, 0.95, PLATE_AMPLITUDE) == (
        "Sensitivity was d′ = 1.20 [0.40, 2.00] for steps of 0.5 µm, and at least d′ = 1.76 "
        "for steps of 0.7 and 1.1 µm (95% intervals)."
    )
