"""The film's closed forms, put into the equations that they solve."""

import re
from functools import partialmethod

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from slipscale.faults import UserError
from slipscale.stimuli.film import infinite_squeeze as film
from slipscale.stimuli.film.reynolds import WorkingPoint, solve
from slipscale.stimuli.film.squeeze_film import Finger, gap, mean_overpressure, mean_pressure

X, T, EPS, DELTA, K, K1, C = sp.symbols("X T epsilon delta k K_1 K", positive=True)
FINGER = Finger()
# The paper's worst case, Fig. 4: h_vib = 3 µm peak, h_r = 1.6 µm.
_, E, D = (float(each) for each in gap(3.0, 1.6))
WAVE = FINGER.wave_number


@pytest.fixture(autouse=True)
def _symbols(monkeypatch):
    """Let NumPy compute with symbols: it calls a method with the name of the function."""
    for function in (sp.cos, sp.sin, sp.sqrt):
        method = partialmethod(lambda each, apply: apply(each), function)
        monkeypatch.setattr(sp.Expr, function.__name__, method, raising=False)
    checked = film._checked
    monkeypatch.setattr(
        film,
        "_checked",
        lambda given: (
            given if any(isinstance(each, sp.Basic) for each in given.values()) else checked(given)
        ),
    )


def is_zero(expression):
    return sp.simplify(sp.nsimplify(expression)) == 0


def flux(psi_squared):
    return film.flux(psi_squared, sp.diff(psi_squared, X), X, DELTA, K)


def test_equation_7_solves_equation_5():
    found = film.psi_squared(X, K1, DELTA, K)
    thickness = film.mean_thickness(X, DELTA, K)
    inner = thickness * sp.diff(found, X) / 2 - found * sp.diff(thickness, X)
    assert is_zero(sp.diff(inner, X))
    assert is_zero(flux(found) - inner)  # (43) is the integral of (5)
    assert is_zero(flux(found))


def test_appendix_a_leaves_an_even_function_without_flux():
    found = film.psi_squared(X, K1, DELTA, K)
    assert is_zero(sp.diff(found, X) / found - film.relative_slope(X, DELTA, K))  # (44)
    varying = sp.Function("varying")(X)
    with_flux = flux(film.psi_squared(X, varying, DELTA, K))  # (45)
    slope = film.slope_of_k1(X, C, DELTA, K)  # (46)
    assert is_zero(with_flux.subs(sp.Derivative(varying, X), slope) - C)
    even = sp.Function("even")(X**2)
    mirrored = flux(even).doit().subs(X, -X).doit()
    assert is_zero(mirrored + flux(even).doit())  # (47)


def test_equation_9_meets_both_edges_and_equation_7():
    squared = film.psi(X, EPS, DELTA, K) ** 2
    edge = film.edge_squared(EPS, DELTA, K)
    assert is_zero(squared.subs(X, sp.Rational(1, 2)) - edge)
    assert is_zero(squared.subs(X, -sp.Rational(1, 2)) - edge)
    assert is_zero(squared - film.psi_squared(X, film.k1_of_edge(edge, DELTA, K), DELTA, K))


def test_equation_10_is_the_ratio_of_its_integrals():
    thickness = film.thickness(sp.Rational(1, 2), T, EPS, DELTA, K)
    ratio = sp.integrate(sp.expand(thickness**3), (T, 0, 2 * sp.pi)) / sp.integrate(
        thickness, (T, 0, 2 * sp.pi)
    )
    assert is_zero(ratio - film.edge_squared(EPS, DELTA, K))


def test_equation_6_is_the_mean_of_equation_2():
    mean = sp.integrate(film.thickness(X, T, EPS, DELTA, K), (T, 0, 2 * sp.pi)) / (2 * sp.pi)
    assert is_zero(mean - film.mean_thickness(X, DELTA, K))


@pytest.mark.parametrize("x", [0.0, 0.0123, 0.0175, 0.31, 0.5])
def test_equation_13_is_the_mean_of_equation_11(x):
    mean = quad(lambda t: film.pressure(x, t, E, D, WAVE), 0, np.pi, epsabs=1e-12)[0] / np.pi
    position = x * FINGER.contact_length_mm
    assert mean == pytest.approx(float(mean_pressure(position, 3.0, 1.6)), rel=1e-9)


def test_equation_12_is_the_mean_over_contact_and_period():
    x = (np.arange(400_000) + 0.5) / 400_000 - 0.5
    phase = (np.arange(64) + 0.5) * np.pi / 64
    mean = np.mean([film.pressure(x, t, E, D, WAVE).mean() for t in phase])
    assert mean - 1 == pytest.approx(float(mean_overpressure(3.0, 1.6)), rel=1e-4)


def test_without_vibration_or_ridges_the_pressure_is_that_of_simpler_films():
    assert is_zero(film.pressure(X, T, sp.Integer(0), DELTA, K) ** 2 - 1)
    flat = film.pressure(X, T, EPS, sp.Integer(0), K)
    assert is_zero(flat - sp.sqrt(1 + sp.Rational(3, 2) * EPS**2) / (1 + EPS * sp.cos(T)))


def test_the_reynolds_equation_approaches_the_closed_form_for_large_squeeze_numbers():
    finger = Finger(ridge_amplitude_um=0.0)
    closed = float(mean_overpressure(1.15, 0.6, finger))
    ratios = []
    for frequency in (30.0, 300.0, 3000.0):
        point = WorkingPoint(
            amplitude_um_peak=1.15, roughness_um=0.6, frequency_hz=frequency, finger=finger
        )
        ratios.append(solve(point).overpressure / closed)
    assert ratios == sorted(ratios)
    assert 0.9 < ratios[-1] < 1


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: film.pressure(0, 0.2, 0.6, 0.5, 10), "1 - eps - delta, is -0.1 of the mean gap"),
        (lambda: film.pressure(0, 0.2, -0.1, 0.5, 10), "eps is -0.1 of the mean gap"),
        (lambda: film.pressure(0, np.nan, 0.1, 0.5, 10), "phase is nan rad"),
        (lambda: film.psi(0.6, 0.1, 0.5, 10), "x is 0.6 l0"),
        (lambda: film.k1_of_edge(1, 1.0, 2 * np.pi), "1 - eps - delta, is 0 of the mean gap"),
        (lambda: film.thickness("a", 0, 0.1, 0.5, 10), "x is 'a', expected a number of l0"),
    ],
)
def test_arguments_outside_their_domain_are_refused(call, words):
    with pytest.raises(UserError, match=re.escape(words)):
        call()


def test_lists_are_arrays():
    found = film.pressure([0, 0.1], 0.2, 0.2, 0.3, 10)
    assert found == pytest.approx([film.pressure(x, 0.2, 0.2, 0.3, 10) for x in (0, 0.1)])
