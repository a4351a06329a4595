"""Growth functions: recovery of known parameters, coverage, and model choice."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.statistics import power_law
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.estimation import sentences as apa
from slipscale.analysis.tasks.estimation.growth import growth_models
from slipscale.analysis.tasks.estimation.growth import statistics as growth
from slipscale.analysis.tasks.estimation.growth.figures import growth as growth_figure
from slipscale.analysis.tasks.productions.statistics import Counterpart, both_exponents
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

DATA = Path(__file__).parents[2] / "data"
R_GROWTH = json.loads((DATA / "r_reference" / "comparisons.json").read_text())["growth"]
STIMULI = np.array([0.5, 1.2, 2.3])
MANY = np.array([0.3, 0.5, 0.8, 1.2, 1.7, 2.3])


def table(shape, stimuli=STIMULI, people=12, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    logs = np.log(shape(stimuli)) + rng.normal(3, 0.7, (people, 1))
    return pd.DataFrame(logs + rng.normal(0, noise, logs.shape), columns=stimuli)


@pytest.mark.parametrize("exponent", [0.3, 0.55, 1.0, 1.7])
def test_exact_power_functions_give_their_exponent(exponent):
    found = power_law.exponents(table(lambda x: x**exponent))
    assert found["exponent"].to_numpy() == pytest.approx(np.full(12, exponent))


def test_exponents_equal_scipy_s_regression_with_holes_and_zero_amplitude():
    from scipy import stats

    logs = table(lambda x: x**0.7, MANY, noise=0.3)
    logs.iloc[2, 1] = np.nan
    logs.iloc[5, 1:] = np.nan
    logs.insert(0, 0.0, 1.0)
    found = power_law.exponents(logs)
    for place in (0, 2):
        own = logs.iloc[place, 1:].dropna()
        line = stats.linregress(np.log(own.index.to_numpy(float)), own.to_numpy())
        assert found["exponent"].iloc[place] == pytest.approx(line.slope)
        assert found["intercept"].iloc[place] == pytest.approx(line.intercept)
    assert np.isnan(found["exponent"].iloc[5])
    assert found["points"].iloc[2] == 5


def test_the_exponent_s_interval_covers_at_its_stated_rate():
    """1,000 studies of 12 whose exponents spread by 0.15 around 0.6: 95 % of intervals hold it."""
    rng = np.random.default_rng(20)
    covered = 0
    for _ in range(1000):
        slopes = rng.normal(0.6, 0.15, (12, 1))
        logs = slopes * np.log(STIMULI) + rng.normal(0, 0.2, (12, 3))
        own = power_law.exponents(pd.DataFrame(logs, columns=STIMULI))["exponent"].to_numpy()
        low, high = mean_over_participants(own, 0.95).interval
        covered += low <= 0.6 <= high
    assert abs(covered / 1000 - 0.95) < 4 * np.sqrt(0.95 * 0.05 / 1000)


SHAPES = {
    "power": (lambda x: x**0.6, {"exponent": 0.6}),
    "threshold": (lambda x: (x - 0.2) ** 0.6, {"exponent": 0.6, "threshold": 0.2}),
    "linear": (lambda x: x + 0.4, {"offset": 0.4}),
    "fechner": (lambda x: np.log(x / 0.1), {"threshold": 0.1}),
    "ekman": (lambda x: 1 + (x / 0.8) ** 1.4, {"exponent": 1.4, "doubling_stimulus": 0.8}),
    "naka_rushton": (
        lambda x: x**1.6 / (x**1.6 + 0.9**1.6),
        {"exponent": 1.6, "half_saturation": 0.9},
    ),
}


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_each_growth_function_recovers_its_own_parameters(name):
    shape, parameters = SHAPES[name]
    found = growth_models.fit(name, MANY, table(shape, MANY).to_numpy())
    assert found.parameters == pytest.approx(parameters, abs=1e-3)
    assert found.sd < 1e-3


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_the_criterion_finds_the_function_that_made_the_data(name):
    """With little noise and six amplitudes; "threshold" contains "power", so it may not lose."""
    shape, _ = SHAPES[name]
    found = growth_models.compare(table(shape, MANY, people=24, noise=0.02, seed=3))
    assert found.best == name
    assert sum(model.weight for model in found.models.values()) == pytest.approx(1)


@pytest.mark.parametrize(
    "name, stimulus", [("ekman", "doubling_stimulus"), ("naka_rushton", "half_saturation")]
)
def test_fits_are_those_of_r_s_own_optimiser(name, stimulus):
    file, estimate, who, stimulus_column = {
        "ekman": ("r_reference/estimates.csv", "est", "participant", "amp"),
        "naka_rushton": ("foreign/co2.csv", "uptake", "Plant", "conc"),
    }[name]
    raw = pd.read_csv(DATA / file)
    logs = raw.assign(log=np.log(raw[estimate])).pivot_table("log", who, stimulus_column)
    found, expected = growth_models.compare(logs).models[name].fit, R_GROWTH[name]
    assert found.log_likelihood == pytest.approx(expected["log_likelihood"], abs=1e-5)
    assert found.aicc == pytest.approx(expected["aicc"], abs=1e-5)
    assert found.parameters["exponent"] == pytest.approx(expected["exponent"], rel=1e-3)
    assert found.parameters[stimulus] == pytest.approx(expected["stimulus"], rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_functions_that_have_the_power_function_as_a_limit_fit_no_worse(seed):
    logs = table(lambda x: x**0.6, MANY, noise=0.2, seed=seed).to_numpy()
    power = growth_models.fit("power", MANY, logs).log_likelihood
    fits = [growth_models.fit(name, MANY, logs) for name in ("ekman", "naka_rushton")]
    assert all(found.log_likelihood > power - 0.05 for found in fits)
    # One bends up and one down: data of a straight line push one of them to its limit.
    assert any(found.at_bound for found in fits)


def test_a_participant_s_unit_moves_no_parameter_and_no_criterion():
    logs = table(lambda x: x**0.6, MANY, noise=0.2)
    shifted = logs + np.arange(12)[:, None]
    for name in growth_models.MODELS:
        one = growth_models.fit(name, MANY, logs.to_numpy())
        other = growth_models.fit(name, MANY, shifted.to_numpy())
        assert one.log_likelihood == pytest.approx(other.log_likelihood, abs=1e-4)


def test_the_likelihood_is_that_of_independent_normal_residuals():
    from scipy import stats

    logs = table(lambda x: x**0.6, MANY, noise=0.2)
    found = growth_models.fit("power", MANY, logs.to_numpy())
    residual = logs.to_numpy() - logs.to_numpy().mean(1, keepdims=True)
    shape = np.log(MANY) * found.parameters["exponent"]
    residual -= shape - shape.mean()
    sd = np.sqrt((residual**2).mean())
    assert found.log_likelihood == pytest.approx(stats.norm.logpdf(residual, 0, sd).sum())
    assert found.aic == pytest.approx(2 * (1 + 12 + 1) - 2 * found.log_likelihood)


def test_two_amplitudes_cannot_tell_functions_apart():
    assert "at least 3" in growth_models.compare(table(lambda x: x, STIMULI[:2])).reason


def test_a_power_of_predicted_friction_is_recovered_against_friction():
    reductions = np.array([growth.predicted_reduction(a) for a in STIMULI])
    logs = table(lambda _: reductions**1.3, noise=0.01)
    logs.insert(0, 0.0, 0.0)
    found = growth.against_friction(logs)
    assert found.exponent.mean == pytest.approx(1.3, abs=0.02)
    assert found.reduction[0.0] == pytest.approx(0, abs=1e-9)
    assert list(found.reduction.values()) == sorted(found.reduction.values())
    assert found.shared_load[0.0] == (0.0, 0.0)
    assert found.shared_load[2.3] == pytest.approx((0.17, 1.0), abs=0.005)


def test_models_closer_than_2_are_undecided_and_a_parameter_at_its_limit_is_named():
    """One was called favoured at a weight of .38, and an exponent of 19.99 stood unannounced."""
    rng = np.random.default_rng(0)
    x = np.array([0.5, 1.2, 2.3])
    logs = pd.DataFrame(0.6 * np.log(x) + rng.normal(0, 0.6, (6, 3)), columns=x)
    found = growth_models.compare(logs)
    deltas = sorted(model.delta_aicc for model in found.models.values())
    assert deltas[1] < 2
    assert found.undecided
    none = NotComputed("not requested")
    text = apa.growth(
        growth.Growth(of_level=found, friction=none, individual=none), 0.95, PLATE_AMPLITUDE
    )
    assert "do not discriminate" in text
    assert "fits best" not in text
    steep = growth_models.fit("power", x, np.array([[0.0, 30.0, 60.0]]))
    assert steep.at_bound == ("exponent",)
    assert growth_models.fit("power", x, 0.6 * np.log(x)[None]).at_bound == ()


def test_the_line_of_the_figure_has_the_exponent_where_cells_are_missing():
    rng = np.random.default_rng(3)
    logs = pd.DataFrame(rng.normal(0, 0.6, (6, 1)) + np.log([[0.5, 1.0, 2.0, 4.0]]))
    logs = logs.set_axis([0.5, 1.0, 2.0, 4.0], axis=1) + rng.normal(0, 0.1, (6, 4))
    logs.iloc[0, 0] = logs.iloc[1, 3] = np.nan
    (_, right) = growth_figure(logs, NotComputed("not of interest here")).axes
    straight = next(line for line in right.lines if line.get_linewidth() == 2)
    x, y = (np.log(np.asarray(each, float)) for each in straight.get_data())
    slope = np.polyfit(x, y, 1)[0]
    assert slope == pytest.approx(power_law.power_law_of(logs, 0.95).exponent)


def test_participants_without_a_positive_exponent_are_named_beside_those_compared():
    own = pd.Series([1.0, 1.1, 1.2, 0.0], index=list("abcd"))
    slopes = own * pd.Series([0.9, 1.1, 1.3, 1.0], index=list("abcd"))
    other = Counterpart(name="magnitude estimation", exponents=slopes)
    found = both_exponents(own, other, 0.95)
    assert (found.n, found.participants) == (3, 4)
