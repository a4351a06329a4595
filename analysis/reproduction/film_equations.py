"""Compare both sides of the film's equations, (1) to (15) and Appendix A, at the paper's numbers.

To record the computed values in ``film_equations.json``, run ``python -m
slipscale.analysis.reproduction.film_equations``. Do this only after an intended change to a model,
and explain in the commit message why the numbers changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

from slipscale.analysis.reproduction.comparison import Outcome, record
from slipscale.analysis.reproduction.equation import Check, apart, items

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.stimuli.quantities import Array, Number

#: The paper's worst case (Fig. 4): h_vib in µm peak and h_r in µm.
VIBRATION_UM, ROUGHNESS_UM = 3.0, 1.6
#: Step of numerical derivatives along X; points of integrals over half a ridge and over a period.
STEP, POINTS, PHASES = 1e-7, 96, 512


def _film() -> tuple[float, float, float, Array, Array]:
    """Return ε, δ, k, and a grid of positions X and phases T."""
    import numpy as np

    from slipscale.stimuli.film.squeeze_film import FINGER, gap

    _, eps, delta = gap(VIBRATION_UM, ROUGHNESS_UM)
    x = np.linspace(-0.49, 0.48, 97)
    phase = (np.arange(PHASES) + 0.5) * 2 * np.pi / PHASES
    return float(eps), float(delta), FINGER.wave_number, x[:, None], phase


def _slope(function: Callable[[Array], Number], x: Array) -> Number:
    return (function(x + STEP) - function(x - STEP)) / (2 * STEP)


def eq1() -> float:
    """Compare the sum in (1) with the thickness that the models use."""
    import numpy as np

    from slipscale.stimuli.film.squeeze_film import FINGER, film_thickness_um

    x_mm, phase = np.linspace(-5, 5, 101)[:, None], np.linspace(0, 6, 13)
    ridges = FINGER.ridge_amplitude_um
    printed = ROUGHNESS_UM + VIBRATION_UM * (1 + np.cos(phase))
    printed = printed + ridges * (1 + np.cos(2 * np.pi / 0.35 * x_mm))
    return apart(printed, film_thickness_um(x_mm, phase, VIBRATION_UM, ROUGHNESS_UM))


def eq2() -> float:
    """Compare (2) times the mean gap with the thickness in µm."""
    from slipscale.stimuli.film import infinite_squeeze as film
    from slipscale.stimuli.film.squeeze_film import FINGER, film_thickness_um, gap

    eps, delta, k, x, phase = _film()
    ours = film_thickness_um(x * FINGER.contact_length_mm, phase, VIBRATION_UM, ROUGHNESS_UM)
    mean = gap(VIBRATION_UM, ROUGHNESS_UM)[0]
    return apart(mean * film.thickness(x, phase, eps, delta, k), ours)


def eq4() -> float:
    """Compare (4) as printed, with l0 in m, with the squeeze number."""
    from slipscale.stimuli.film.squeeze_film import FINGER, squeeze_number

    right = float(squeeze_number(30_500, 1.15, 0.6))
    return apart(right / (FINGER.contact_length_mm * 1e-3), right)


def eq5() -> float:
    """Compare the two terms in the brackets of (5), by numerical derivatives of (7) and (6)."""
    from slipscale.stimuli.film import infinite_squeeze as film

    _, delta, k, x, _ = _film()
    squared = partial(film.psi_squared, k1=1.3, delta=delta, k=k)
    mean = partial(film.mean_thickness, delta=delta, k=k)
    return apart(mean(x) * _slope(squared, x) / 2, squared(x) * _slope(mean, x))


def eq6() -> float:
    """Compare (6) with the mean of (2) over a period."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film

    eps, delta, k, x, phase = _film()
    mean = np.mean(film.thickness(x, phase, eps, delta, k), axis=1, keepdims=True)
    return apart(film.mean_thickness(x, delta, k), mean)


def eq7() -> float:
    """Compare the slope of (7) with the one that (43) requires if K = 0."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film

    _, delta, k, x, _ = _film()
    squared = partial(film.psi_squared, k1=1.3, delta=delta, k=k)
    slope = _slope(squared, x)
    scale = np.max(np.abs(slope))
    return apart(film.flux(squared(x), slope, x, delta, k) + scale, scale)


def eq8() -> float:
    """Compare (7) at both edges with the edge value that defines K1."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film

    _, delta, k, *_ = _film()
    k1 = film.k1_of_edge(1.7, delta, k)
    return apart(film.psi_squared(np.array([-0.5, 0.5]), k1, delta, k), 1.7)


def eq9() -> float:
    """Compare the square of (9) with (7) and (8)."""
    from slipscale.stimuli.film import infinite_squeeze as film

    eps, delta, k, x, _ = _film()
    k1 = film.k1_of_edge(film.edge_squared(eps, delta, k), delta, k)
    return apart(film.psi(x, eps, delta, k) ** 2, film.psi_squared(x, k1, delta, k))


def _edge_ratio() -> float:
    """Return the ratio of the integrals in (10)."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film

    eps, delta, k, _, phase = _film()
    edge = film.thickness(0.5, phase, eps, delta, k)
    return float(np.mean(edge**3) / np.mean(edge))


def eq10() -> float:
    """Compare the last line of (10) as printed with the ratio of the integrals; p0² cancels."""
    import numpy as np

    eps, delta, k, *_ = _film()
    ridge = delta * np.cos(k / 2)
    return apart((1 + ridge) * (1 + 1.5 * eps**2 / ridge**2), _edge_ratio())


def eq11() -> float:
    """Compare (11) as printed, at the edge, with P∞ = Ψ∞/H from the integrals in (10)."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film
    from slipscale.stimuli.film.squeeze_film import AIR

    eps, delta, k, _, phase = _film()
    right = np.sqrt(_edge_ratio()) / film.thickness(0.5, phase, eps, delta, k)
    return apart(AIR.pressure_pa * film.pressure(0.5, phase, eps, delta, k), right)


def eq12() -> float:
    """Compare F_s with both integrals in (12), by quadrature between the ridges' extremes."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film
    from slipscale.stimuli.film.squeeze_film import mean_overpressure

    eps, delta, k, _, phase = _film()
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    extremes = np.pi / k * np.arange(np.ceil(-k / 2 / np.pi), k / 2 / np.pi)
    ends = np.array([-0.5, *extremes, 0.5])
    total = 0.0
    for low, high in pairwise(ends):
        x = low + (high - low) * (1 + nodes[:, None]) / 2
        over = np.mean(film.pressure(x, phase, eps, delta, k) - 1, axis=1)
        total += float(weights @ over) * (high - low) / 2
    return apart(total, mean_overpressure(VIBRATION_UM, ROUGHNESS_UM))


def eq13() -> float:
    """Compare (13) as printed with the mean of Ψ∞/H over a period, by the trapezium rule."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film
    from slipscale.stimuli.film.squeeze_film import AIR, FINGER, mean_pressure

    eps, delta, k, x, phase = _film()
    mean = np.mean(film.pressure(x, phase, eps, delta, k), axis=1, keepdims=True)
    ours = mean_pressure(x * FINGER.contact_length_mm, VIBRATION_UM, ROUGHNESS_UM)
    return apart(mean, AIR.pressure_pa * ours)


def eq15() -> float:
    """Compare (15) as printed, where P_f is in Pa, with the force that the film leaves."""
    from slipscale.stimuli.film.squeeze_film import AIR, FINGER, NORMAL_FORCE_N, mean_overpressure

    over = float(mean_overpressure(1.5, 0.6))
    area_m2 = (FINGER.contact_length_mm * 1e-3) ** 2
    left_n = NORMAL_FORCE_N - over * AIR.pressure_pa * area_m2
    return apart(1 - over / (NORMAL_FORCE_N / area_m2), left_n / NORMAL_FORCE_N)


def eq43(*, mirrored: bool = False) -> float:
    """Compare (43), or (47) at -X, with K, for the Ψ1² of (45) whose K1(X) is integrated (46)."""
    from slipscale.stimuli.film import infinite_squeeze as film

    _, delta, k, x, _ = _film()
    constant, k1 = 0.4, 1.3

    def squared(at: Array) -> Number:
        # K1 is k1 at x; near x, Simpson's rule integrates (46).
        low, middle, high = (film.slope_of_k1(z, constant, delta, k) for z in (x, (x + at) / 2, at))
        return film.psi_squared(at, k1 + (at - x) * (low + 4 * middle + high) / 6, delta, k)

    slope = _slope(squared, x)
    if mirrored:
        # An even function has the opposite slope at -X.
        return apart(film.flux(squared(x), -slope, -x, delta, k), -constant)
    return apart(film.flux(squared(x), slope, x, delta, k), constant)


def eq44() -> float:
    """Compare (44) with the numerical slope of the logarithm of (7)."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film

    _, delta, k, x, _ = _film()
    logarithm = _slope(lambda at: np.log(film.psi_squared(at, 1.3, delta, k)), x)
    return apart(film.relative_slope(x, delta, k), logarithm)


CHECKS: Mapping[int, Check] = {
    1: Check(difference=eq1, reason="definition of the thickness", definition=True),
    2: Check(
        difference=eq2,
        reason="definition of ε, δ and k; (1) divided by the mean gap",
        definition=True,
    ),
    4: Check(
        difference=eq4,
        reason="printed with l0; only l0² gives a number without unit, and 15.9 at 30.5 kHz",
    ),
    5: Check(difference=eq5, reason="both terms with (7) and (6), by numerical derivatives"),
    6: Check(difference=eq6, reason="the mean of (2) over a period"),
    7: Check(difference=eq7, reason="its numerical slope satisfies (43) with K = 0"),
    8: Check(difference=eq8, reason="definition of K1 by the value at the edges", definition=True),
    9: Check(difference=eq9, reason="its square is (7) with K1 from (8)", definition=True),
    10: Check(
        difference=eq10,
        reason="the last line must be A² (1 + 1.5 ε²/A²), with A = 1 + δ cos(k/2), the ratio of "
        "the integrals by quadrature; (11) and (13) already use it. All lines contain p0², but Ψ "
        "is relative to p0",
    ),
    11: Check(
        difference=eq11,
        reason="printed with the factor p0, although P∞ is relative to p0; without it, (11) "
        "gives the ratio of the integrals in (10) at the edge, by quadrature",
    ),
    12: Check(
        difference=eq12,
        reason="both integrals by quadrature, with the P∞ of (11) without the factor p0",
    ),
    13: Check(
        difference=eq13,
        reason="printed with the factor p0, although the pressure is relative to p0; without it, "
        "(13) is the mean of (11) over a period, by quadrature",
    ),
    15: Check(
        difference=eq15,
        reason="as printed, P∞ - 1 has no unit and P_f is in Pa; 1 - p0·F_s/P_f, with the mean F_s "
        "of (12), gives 0.48 at h_r = 0.6 and h_vib = 1.5 µm, the paper's half "
        "(fig5.hr0.6.hvib1.5)",
    ),
    43: Check(
        difference=eq43,
        reason="K, for the numerical slope of the Ψ1² of (45), with (46) integrated numerically",
        also=(45, 46),
    ),
    44: Check(difference=eq44, reason="numerical slope of the logarithm of (7)"),
    47: Check(
        difference=partial(eq43, mirrored=True),
        reason="(43) at -X, with the numerical slope of an even Ψ²",
    ),
}
ITEMS: Mapping[str, Callable[[], Outcome]] = items(CHECKS)
FIGURES: Mapping[str, Callable[[], Figure]] = {}


if __name__ == "__main__":
    record(ITEMS, "film_equations.json")
