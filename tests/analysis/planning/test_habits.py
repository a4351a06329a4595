"""Each habit is found by the analysis that claims to see it, and by none when it is off."""

from functools import cache

import numpy as np
import pytest

from slipscale.analysis.planning.simulated.dataset import simulated_dataset
from slipscale.analysis.planning.simulated.estimates import Task, simulate_ratings
from slipscale.analysis.preprocessing.data_quality import flags, measures
from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.preprocessing.normalisation import normalise
from slipscale.analysis.preprocessing.residuals import residuals
from slipscale.analysis.statistics.power_law import power_law
from slipscale.analysis.tasks.estimation.order_effects import order_effects
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.participants.simulated_people.habits import Habits
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.analysis_choices import AnalysisChoices

AMPLITUDES = (0.5, 0.95, 1.4, 1.85, 2.3)
CHOICES = AnalysisChoices()
# Scales are alike here, so that only what is tested differs; noise is small.
QUIET = {"scale_tops": (100.0,), "trial_to_trial": 0.1, "shared": 0.6}


@cache
def study(amplitudes=AMPLITUDES, participants=120, repetitions=6, **habits):
    """Return one simulated study and what the analysis prepares of it."""
    ratings = simulate_ratings(
        Task(levels=amplitudes, repetitions=repetitions, practice=1),
        participants=participants,
        studies=1,
        population=Population(**QUIET, habits=Habits(**habits)),
        rng=np.random.default_rng(3),
    )
    data = simulated_dataset(ratings, 0, amplitudes, CHOICES, declared=True)
    estimates = data.estimates.assign(normalised=normalise(data.estimates, "scale_top"))
    return data, prepare(estimates, CHOICES)


def order(**habits):
    found = order_effects(study(**habits)[1])
    return found.log_slope_per_trial, found.log_slope_per_level_before


def exponent(amplitudes=AMPLITUDES, **habits):
    return power_law(study(amplitudes, **habits)[1]).exponent


def test_without_habits_the_order_s_analysis_sees_none():
    for slope in order():
        assert slope.interval.low < 0 < slope.interval.high


def test_carry_over_is_the_slope_on_the_surface_before():
    slope = order(carry_over=0.06)[1]
    assert slope.interval.low < 0.06 < slope.interval.high
    assert slope.interval.low > 0.02


def test_fatigue_is_the_slope_on_the_trial():
    slope = order(fatigue=0.01)[0]
    assert slope.interval.low < -0.01 < slope.interval.high
    assert slope.interval.high < -0.006


def test_a_finger_that_settles_is_a_rising_slope_within_a_block():
    slope = order(settling=0.5)[0]
    prepared = study(settling=0.5)[1]
    trials = prepared.trials
    place = (trials["position"] - 1) % len(AMPLITUDES)
    left = residuals(trials[trials["log"].notna()], prepared.logs)
    place = place[trials["log"].notna()].to_numpy()
    assert left[place == 4].mean() - left[place == 0].mean() > 0.1
    assert slope.interval.high > 0


def test_regression_shrinks_the_exponent_by_its_share():
    assert exponent(regression=0.3) / exponent() == pytest.approx(0.7, abs=0.07)


def test_a_range_effect_makes_the_exponent_of_a_small_range_larger():
    small = (1.2, 1.4, 1.6)
    assert exponent(small, range_effect=0.4) > 1.25 * exponent(small)
    # The whole range is the one that nothing is stretched to.
    whole = (0.0, *AMPLITUDES)
    assert exponent(whole, range_effect=0.4) == pytest.approx(exponent(whole), rel=0.15)


def test_learning_makes_the_second_half_s_residuals_smaller():
    def ratio(**habits):
        _, prepared = study(**habits)
        trials = prepared.trials[prepared.trials["level"] > 1]
        late = trials["position"] > 15
        cells = trials.groupby([PARTICIPANT, "level", late], observed=True)["log"]
        spread = cells.std().groupby(level=2).mean()
        return spread[True] / spread[False]

    assert ratio() == pytest.approx(1, abs=0.07)
    assert ratio(learning=0.4) < 0.9


def test_rounding_is_the_share_of_round_estimates():
    def round_share(**habits):
        return (study(**habits)[0].estimates["estimate"] % 5 == 0).mean()

    # One in five is round by chance: of the rest the habit rounds its share.
    assert round_share() == pytest.approx(0.2, abs=0.05)
    assert round_share(rounding=0.7) == pytest.approx(0.2 + 0.8 * 0.7, abs=0.04)


def test_lapses_are_flagged_as_outlying():
    def outlying(**habits):
        data, _ = study(**habits)
        return np.nansum(measures(data, CHOICES.thresholds)["outlying"].to_numpy(float))

    assert outlying(lapses=0.05) > outlying() + 0.01 * 120 * 30


def test_who_misreads_is_flagged_as_falling_from_one_amplitude_to_the_next():
    def falling(**habits):
        data, _ = study(**habits)
        thresholds = CHOICES.thresholds.model_copy(update={"falling_steps": 3})
        return flags(measures(data, thresholds), thresholds)["non_monotone"].mean()

    assert falling() < 0.03
    assert falling(misread=0.25) == pytest.approx(0.25, abs=0.1)


def test_who_drops_out_leaves_trials_unanswered():
    data, _ = study(dropout=0.4)
    counts = data.estimates["participant_id"].value_counts()
    # Evenly over practice and main trials; who stops in practice has no main trial.
    left = 120 - (counts == 30).sum()
    assert left / 120 == pytest.approx(0.4, abs=0.12)


def half_width(amplitudes):
    ratings = simulate_ratings(
        Task(levels=tuple(amplitudes)),
        participants=12,
        studies=60,
        population=Population(),
        rng=np.random.default_rng(1),
    )
    widths = []
    for number in range(60):
        data = simulated_dataset(ratings, number, amplitudes, CHOICES, declared=True)
        estimates = data.estimates.assign(normalised=normalise(data.estimates, "scale_top"))
        interval = power_law(prepare(estimates, CHOICES)).interval
        widths.append((interval.high - interval.low) / 2)
    return np.mean(widths)


def test_24_amplitudes_in_one_range_do_not_halve_the_interval_of_3():
    """A person's own deviations are no white noise that more amplitudes average out."""
    few, many = half_width(np.linspace(0.5, 2.3, 3)), half_width(np.linspace(0.5, 2.3, 24))
    assert 0.6 < many / few < 0.95
