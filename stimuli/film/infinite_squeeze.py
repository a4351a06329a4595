"""Express the film for infinite squeeze numbers, equations (5) to (11) and Appendix A (43) to (47).

All arguments and results have no unit, as in equation (2): ``x`` is the position X = x/l0 from the
centre of the contact (-1/2 to 1/2), ``phase`` is T = ω0·t, ``eps`` and ``delta`` are ε and δ
(ε + δ < 1, as `slipscale.stimuli.film.squeeze_film.gap` returns them), and ``k`` is the wave number
2π l0/L. Pressures are relative to p0. Ψ = P·H; P is normalised throughout, whereas the paper mixes
p0 with normalised pressures in (10) to (13). The paper considers squeeze numbers above 10
sufficient; under a ridged finger, about 10⁴ is required.

Every function checks its arguments (see `DOMAINS`) and accepts lists. A UserError names the
argument, its unit and its range.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import signature

import numpy as np

from slipscale.stimuli.quantities import Number, between, positive

#: Argument -> its unit, and its smallest and largest value.
DOMAINS: dict[str, tuple[str, float, float]] = {
    "x": ("l0", -0.5, 0.5),
    "phase": ("rad", -np.inf, np.inf),
    "eps": ("of the mean gap", 0, 1),
    "delta": ("of the mean gap", 0, 1),
    "k": ("rad", 0, np.inf),
    "k1": ("p0²", 0, np.inf),
    "edge_squared": ("p0²", 0, np.inf),
    "psi_squared": ("p0²", 0, np.inf),
    "slope": ("p0² per l0", -np.inf, np.inf),
    "constant": ("p0² per l0", -np.inf, np.inf),
}


def _checked(given: dict[str, Number]) -> dict[str, Number]:
    """Return the arguments as arrays of floats, if they are in `DOMAINS` and the gap is open."""
    found: dict[str, Number] = {
        name: between(name, value, *DOMAINS[name]) for name, value in given.items()
    }
    least = 1 - found.get("eps", 0.0) - found.get("delta", 0.0)
    positive("the smallest gap, 1 - eps - delta,", least, "of the mean gap")
    return found


def _in_domain(function: Callable[..., Number]) -> Callable[..., Number]:
    names = tuple(signature(function).parameters)

    @wraps(function)
    def checked(*args: Number, **named: Number) -> Number:
        return function(**_checked(dict(zip(names, args, strict=False)) | named))

    return checked


@_in_domain
def mean_thickness(x: Number, delta: Number, k: Number) -> Number:
    """Return the mean thickness H̄ over a period, equation (6)."""
    return 1 + delta * np.cos(k * x)


@_in_domain
def thickness(x: Number, phase: Number, eps: Number, delta: Number, k: Number) -> Number:
    """Return the thickness H, equation (2)."""
    return mean_thickness(x, delta, k) + eps * np.cos(phase)


@_in_domain
def flux(psi_squared: Number, slope: Number, x: Number, delta: Number, k: Number) -> Number:
    """Return K, the integral of equation (5), by equation (43).

    Parameters
    ----------
    psi_squared, slope : array
        Ψ∞² and its derivative dΨ∞²/dX at ``x``. By (5), the result is the same at every ``x``. At
        -X it has the opposite sign, equation (47), so that K = 0 for an even Ψ∞².
    """
    return mean_thickness(x, delta, k) * slope / 2 + psi_squared * k * delta * np.sin(k * x)


@_in_domain
def relative_slope(x: Number, delta: Number, k: Number) -> Number:
    """Return dΨ∞²/Ψ∞² per dX for K = 0, equation (44)."""
    return -2 * delta * k * np.sin(k * x) / mean_thickness(x, delta, k)


@_in_domain
def psi_squared(x: Number, k1: Number, delta: Number, k: Number) -> Number:
    """Return Ψ∞² for the constant K1, equation (7), or Ψ1² for K1(X), equation (45)."""
    return k1 * mean_thickness(x, delta, k) ** 2


@_in_domain
def slope_of_k1(x: Number, constant: Number, delta: Number, k: Number) -> Number:
    """Return K1'(X) for the constant K, equation (46)."""
    return 2 * constant / mean_thickness(x, delta, k) ** 3


@_in_domain
def k1_of_edge(edge_squared: Number, delta: Number, k: Number) -> Number:
    """Return K1 for the value of Ψ∞² at both edges, X = ±1/2, equation (8)."""
    return edge_squared / mean_thickness(0.5, delta, k) ** 2


@_in_domain
def edge_squared(eps: Number, delta: Number, k: Number) -> Number:
    """Return Ψ∞B² at the edges, equation (10).

    The last line of (10) is corrected to A² (1 + 1.5 ε²/A²), with A = 1 + δ cos(k/2).
    """
    return mean_thickness(0.5, delta, k) ** 2 + 1.5 * eps**2


@_in_domain
def psi(x: Number, eps: Number, delta: Number, k: Number) -> Number:
    """Return Ψ∞ inside the contact, equation (9)."""
    edge: Number = np.sqrt(edge_squared(eps, delta, k))
    return edge * np.abs(mean_thickness(x, delta, k)) / np.abs(mean_thickness(0.5, delta, k))


@_in_domain
def pressure(x: Number, phase: Number, eps: Number, delta: Number, k: Number) -> Number:
    """Return the normalised pressure P∞, equation (11)."""
    return psi(x, eps, delta, k) / thickness(x, phase, eps, delta, k)
