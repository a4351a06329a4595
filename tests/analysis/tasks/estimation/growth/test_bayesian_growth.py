"""The hierarchical Bayesian power function: its likelihood, recovery, checks, and its absence.

What samples runs where the extra slipscale[bayes] is installed, and is skipped elsewhere.
"""

import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing.log_transform import prepare
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.analysis.tasks.estimation.growth.bayesian_growth import bayesian_growth
from slipscale.analysis.tasks.estimation.growth.hierarchical_sampler import (
    LKJ,
    PRIOR_SD,
    Trials,
    model,
    own_lines,
    sums,
)
from slipscale.commands import main
from slipscale.experiments.study.analysis_choices import AnalysisChoices
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

AMPLITUDES = np.array([0.3, 0.6, 1.2, 2.3])
PEOPLE = 10


def ready(logs):
    """Logs, shape (people, amplitudes, repetitions)."""
    who, what, _ = np.indices(logs.shape)
    frame = pd.DataFrame(
        {
            "participant_id": pd.Categorical([f"p{i:02d}" for i in who.ravel()]),
            "level": AMPLITUDES[what.ravel()],
            "normalised": np.exp(logs.ravel()),
            "session": "",
            "run": "1",
        }
    )
    return prepare(frame, AnalysisChoices())


def lines(rng, slopes, *, noise=0.3, bend=0.0):
    x = np.log(AMPLITUDES)
    shape = slopes[:, None] * x - bend * x**2
    own = rng.normal(3, 0.5, (len(slopes), 1))
    return (own + shape)[..., None] + rng.normal(0, noise, (len(slopes), len(x), 4))


@pytest.fixture(scope="module")
def installed():
    return pytest.importorskip(
        "numpyro", reason="needs slipscale[bayes]: numpyro, 360 MB, which no test set installs"
    )


@pytest.fixture(scope="module")
def slopes():
    return np.random.default_rng(4).normal(0.6, 0.25, PEOPLE)


@pytest.fixture(scope="module")
def found(installed, slopes):
    return bayesian_growth(ready(lines(np.random.default_rng(5), slopes)))


def test_the_density_is_that_of_normal_trials_with_normal_lines_and_the_priors(installed):
    import jax
    from numpyro.infer.util import log_density

    rng = np.random.default_rng(1)
    who = np.array([0, 0, 0, 1, 1, 2])  # one with two trials, one with a single one
    trials = Trials(
        log_y=rng.normal(0, 1, 6), log_x=rng.normal(0, 1, 6), who=who, names=("a", "b", "c")
    )
    values = {"A": 0.3, "B": 0.8, "ta": 0.7, "tb": 0.2, "s": 0.4, "half_r": 0.7}
    known = sums(trials)
    with jax.enable_x64(True):
        args = (known.xx, known.xy, known.yy, known.trials)
        ours = float(log_density(model, args, {}, values)[0])
    covariance = values["ta"] * values["tb"] * (2 * values["half_r"] - 1)
    spread = np.array([[0.7**2, covariance], [covariance, 0.2**2]])
    expected = sum(stats.norm.logpdf(values[name], 0, PRIOR_SD[name]) for name in ("A", "B"))
    expected += sum(
        stats.halfnorm.logpdf(values[name], 0, PRIOR_SD[name]) for name in ("ta", "tb", "s")
    )
    expected += stats.beta.logpdf(values["half_r"], LKJ, LKJ)
    for person in range(3):
        x = np.stack([np.ones((who == person).sum()), trials.log_x[who == person]], axis=1)
        expected += stats.multivariate_normal.logpdf(
            trials.log_y[who == person], x @ [0.3, 0.8], x @ spread @ x.T + 0.4**2 * np.eye(len(x))
        )
    # The factor leaves out the constant of the normal density.
    assert ours - 6 * 0.5 * np.log(2 * np.pi) == pytest.approx(expected, rel=1e-9)


def test_lines_drawn_afterwards_are_normal_given_the_rest():
    """Against the dense normal distribution of lines and trials, conditioned on the trials."""
    rng = np.random.default_rng(3)
    who = np.repeat([0, 1], [5, 1])
    trials = Trials(log_y=rng.normal(0, 1, 6), log_x=rng.normal(0, 1, 6), who=who, names=("a", "b"))
    values = {"A": 0.3, "B": 0.8, "ta": 0.7, "tb": 0.4, "s": 0.5, "half_r": 0.8}
    drawn = {name: np.full((1, 40_000), value) for name, value in values.items()}
    lines_drawn = own_lines(sums(trials), drawn, np.random.default_rng(4))[0]
    covariance = 0.7 * 0.4 * 0.6
    spread = np.array([[0.7**2, covariance], [covariance, 0.4**2]])
    for person in range(2):
        x = np.stack([np.ones((who == person).sum()), trials.log_x[who == person]], axis=1)
        gain = spread @ x.T @ np.linalg.inv(x @ spread @ x.T + 0.5**2 * np.eye(len(x)))
        centre = [0.3, 0.8] + gain @ (trials.log_y[who == person] - x @ [0.3, 0.8])
        own = lines_drawn[:, person]
        assert own.mean(axis=0) == pytest.approx(centre, abs=0.015)
        assert np.cov(own.T) == pytest.approx(spread - gain @ x @ spread, abs=0.015)


def test_exponents_are_recovered_and_drawn_to_the_group(found, slopes):
    assert found.converged
    assert found.interval.low < slopes.mean() < found.interval.high
    assert found.sd_exponent_interval.low < 0.25 < found.sd_exponent_interval.high
    alone = np.array([one.least_squares for one in found.individuals])
    drawn = np.array([one.exponent for one in found.individuals])
    assert 0.02 < found.shrinkage < 0.6
    assert drawn.std() < alone.std()
    held = [
        one.interval.low < s < one.interval.high
        for one, s in zip(found.individuals, slopes, strict=True)
    ]
    assert sum(held) >= 8
    assert ((drawn - slopes) ** 2).mean() < ((alone - slopes) ** 2).mean() * 1.2


def test_the_same_data_give_the_same_numbers(found, slopes):
    assert bayesian_growth(ready(lines(np.random.default_rng(5), slopes))) == found


def test_predictions_agree_with_data_of_the_model_and_miss_a_curve(found, slopes):
    assert all(0.025 < check.p < 0.975 for check in found.checks.values())
    bent = bayesian_growth(ready(lines(np.random.default_rng(6), slopes, bend=0.4)))
    assert min(bent.checks["curvature"].p, 1 - bent.checks["curvature"].p) < 0.01
    text = apa.bayesian_growth(bent, 0.95, PLATE_AMPLITUDE)
    assert "do not agree with the data in the curvature on logarithmic" in text
    assert "agree with the data in the curvature" in apa.bayesian_growth(
        found, 0.95, PLATE_AMPLITUDE
    )


def test_numbers_of_chains_that_do_not_agree_are_not_reported(found):
    text = apa.bayesian_growth(replace(found, r_hat=1.2), 0.95, PLATE_AMPLITUDE)
    assert "did not converge (largest R̂ = 1.200, 0 divergences)" in text
    assert "exponent of" not in text


def test_the_figure_shows_everybody_twice(found):
    from slipscale.analysis.tasks.estimation.growth.exponents_figure import exponents

    (axes,) = exponents(found).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == [
        one.participant for one in sorted(found.individuals, key=lambda one: one.exponent)
    ]
    rings = next(line for line in axes.lines if line.get_label() == "from own trials only")
    assert sorted(rings.get_xdata()) == sorted(one.least_squares for one in found.individuals)


@pytest.mark.parametrize(
    "logs, why",
    [
        (np.zeros((2, 4, 3)), "too few participants (2; at least 3 are needed)"),
        (np.zeros((5, 1, 3)), "too few amplitudes above 0 (1; at least 2 are needed)"),
        (np.zeros((5, 2, 1)), "so there are no residuals"),
    ],
)
def test_too_little_is_not_sampled(logs, why):
    assert why in bayesian_growth(ready(logs)).reason


def test_it_is_neither_computed_nor_loaded_unless_asked_for(dataset):
    found = analyse(dataset()).inference.bayesian_growth
    assert found == NotComputed("not requested (--bayesian)")


def test_a_missing_extra_is_one_sentence_before_anything_is_computed(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "numpyro", None)
    assert main(["analyse", str(tmp_path / "nothing.csv"), "--bayesian"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "pip install 'slipscale[bayes]'" in error
