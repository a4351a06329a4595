"""A population fitted to simulated people is the one that they were simulated from."""

import numpy as np
import pytest

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.planning.fitted_population import fit_population
from slipscale.analysis.planning.simulated.dataset import simulated_dataset
from slipscale.analysis.planning.simulated.estimates import Task, simulate_ratings
from slipscale.experiments.participants.simulated_people.habits import Habits
from slipscale.experiments.participants.simulated_people.population import (
    AMPLITUDE_UM_PP,
    Population,
)
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")

CHOICES = AnalysisChoices(tests=("order",))


def analysed(participants, population, amplitudes=AMPLITUDE_UM_PP, repetitions=4):
    ratings = simulate_ratings(
        Task(levels=amplitudes, repetitions=repetitions),
        participants=participants,
        studies=1,
        population=population,
        rng=np.random.default_rng(4),
    )
    return analyse(simulated_dataset(ratings, 0, amplitudes, CHOICES, declared=True))


@pytest.fixture(scope="module")
def fitted():
    people = Population(
        shared=0.7,
        trial_to_trial=0.1,
        noise_sigma=0.0,
        habits=Habits(rounding=0.5, carry_over=0.08),
    )
    return people, fit_population(analysed(300, people))


@pytest.mark.parametrize("shared, trial", [(0.7, 0.1), (0.3, 0.4)])
def test_the_parts_of_the_variance_are_found_again(shared, trial):
    people = Population(shared=shared, trial_to_trial=trial, noise_sigma=0.0)
    found = fit_population(analysed(300, people)).population
    assert found.mean_sensation == pytest.approx(people.mean_sensation, abs=2)
    assert found.sd_sensation == pytest.approx(people.sd_sensation, rel=0.25)
    assert found.shared == pytest.approx(shared, abs=0.1)
    assert found.trial_to_trial == pytest.approx(trial, abs=0.05)


def test_habits_that_the_data_show_are_fitted(fitted):
    people, found = fitted
    assert found.population.habits.rounding == pytest.approx(people.habits.rounding, abs=0.08)
    assert found.population.habits.carry_over == pytest.approx(people.habits.carry_over, abs=0.03)
    assert found.population.habits.fatigue == 0


def test_it_says_of_every_number_whether_it_was_fitted_or_assumed(fitted):
    _, found = fitted
    fields = set(Population.model_fields) - {"name", "habits", "levels"} | {"amplitude_um_pp"}
    told = {name for name in found.fitted if "." not in name}
    assert told | set(found.assumed) == fields
    assert not told & set(found.assumed)
    # Nobody's times are in these data, and no difference was asked for.
    assert {"answer_s", "criterion", "reading_words_per_minute"} <= set(found.assumed)
    assert any(line.startswith("fitted   shared = ") for line in found.sentences)
    assert found.sentences[-1].startswith("assumed  ")


def test_two_people_are_no_population():
    with pytest.raises(UserError, match="2 people with an estimate at each of 4 amplitudes"):
        fit_population(analysed(2, Population()))
