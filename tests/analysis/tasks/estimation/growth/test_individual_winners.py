"""The growth function that each participant's single trials favour."""

import numpy as np
import pandas as pd
import pytest
from scipy import optimize

from slipscale.analysis.tasks.estimation.growth.growth_models import MODELS
from slipscale.analysis.tasks.estimation.growth.individual_winners import (
    individual_winners,
    least_squares,
)

STIMULI = np.array([0.5, 1.2, 2.3])


def test_single_participants_need_enough_trials_to_be_told_apart():
    rng = np.random.default_rng(2)
    amplitudes = np.repeat(STIMULI, 8)
    rows = pd.DataFrame(
        {
            "participant_id": pd.Categorical(["a"] * 24 + ["b"] * 3),
            "level": [*amplitudes, *STIMULI],
            "log": [*(0.4 * np.log(amplitudes) + rng.normal(0, 0.02, 24)), 1.0, 2.0, 2.5],
        }
    )
    winners = individual_winners(rows)
    assert winners["a"] == "power"
    assert winners["b"] is None


@pytest.mark.parametrize("unit", [1.0, 1000.0])
@pytest.mark.parametrize("name", MODELS)
def test_squares_of_a_batch_are_those_of_single_searches_by_scipy(name, unit):
    rng = np.random.default_rng(5)
    x, people, trials = unit * np.array([0.4, 0.7, 1.2, 1.8, 2.3]), 6, 4
    exponents = rng.normal(0.8, 0.2, people)[:, None, None]
    logs = exponents * np.log(x)[:, None] + rng.normal(0, 0.15, (people, len(x), trials))
    means = logs.mean(axis=2)
    ours = least_squares(MODELS[name], x, means, np.full_like(means, trials))
    ours += ((logs - means[..., None]) ** 2).sum(axis=(1, 2))
    model, every = MODELS[name], np.repeat(x, trials)
    low, high = model.bounds(x)
    for found, own in zip(ours, logs.reshape(people, -1), strict=True):
        searches = [
            optimize.least_squares(
                lambda q, own=own: own - q[-1] - model.log_f(every, q[:-1]),
                [*start, own.mean()],
                bounds=([*low, -50.0], [*high, 50.0]),
                x_scale="jac",
                ftol=1e-14,
                xtol=1e-14,
                gtol=1e-14,
                max_nfev=5000,
            )
            for start in model.starts(x)
        ]
        assert found == pytest.approx(2 * min(each.cost for each in searches), rel=1e-6)


def test_participants_with_other_stimuli_are_judged_as_if_alone():
    rng = np.random.default_rng(8)
    five = np.array([0.3, 0.5, 0.9, 1.5, 2.3])
    shown = {"a": five, "b": 3 * five, "c": np.append(five, 1.2), "d": five}
    frames = []
    for place, (who, stimuli) in enumerate(shown.items()):
        x = np.repeat(stimuli, 10 + place)
        log = np.log(np.log(x / (0.2 * stimuli[0]))) + rng.normal(0, 0.001, len(x))
        frames.append(pd.DataFrame({"participant_id": who, "level": x, "log": log}))
    together = individual_winners(pd.concat(frames, ignore_index=True))
    assert set(together.values()) == {"fechner"}
    assert all(individual_winners(own).items() <= together.items() for own in frames)


def test_trials_that_two_functions_fit_exactly_favour_the_one_of_fewer_parameters():
    x = np.repeat([0.3, 0.5, 1.2, 2.3], 3)
    rows = pd.DataFrame({"participant_id": "a", "level": x, "log": 0.7 * np.log(x)})
    assert individual_winners(rows) == {"a": "power"}
