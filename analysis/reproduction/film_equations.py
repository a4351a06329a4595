"""Compare both sides of the film's equations, (1) to (15) and Appendix A, at the paper's numbers.

To record the computed values in ``film_equations.json``, run ``python -m
slipscale.analysis.reproduction.film_equations``. Do this only after an intended change to a model,
and explain in the commit message why the numbers changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from slipscale.analysis.reproduction.comparison import Outcome, item, record
from slipscale.analysis.reproduction.equation import Check, apart, items

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.stimuli.quantities import Array, Number

#: The paper's worst case (Fig. 4): h_vib in µm peak and h_r in µm.
VIBRATION_UM, ROUGHNESS_UM = 3.0, 1.6
#: Step of numerical derivatives along X, and points of mean values over the contact and a period.
STEP, POINTS, PHASES = 1e-6, 200_000, 64


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
    """Compare the last line of (10) as printed with the ratio of the integrals."""
    import numpy as np

    eps, delta, k, *_ = _film()
    ridge = delta * np.cos(k / 2)
    return apart((1 + ridge) * (1 + 1.5 * eps**2 / ridge**2), _edge_ratio())


def eq11() -> float:
    """Compare (P·H)² of (11) at the edge with the ratio of the integrals in (10)."""
    from slipscale.stimuli.film import infinite_squeeze as film

    eps, delta, k, _, phase = _film()
    product = film.pressure(0.5, phase, eps, delta, k) * film.thickness(0.5, phase, eps, delta, k)
    return apart(product**2, _edge_ratio())


def eq12() -> float:
    """Compare (12) with mean values of (11) over the contact and a period."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film
    from slipscale.stimuli.film.squeeze_film import mean_overpressure

    eps, delta, k, _, phase = _film()
    x = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    mean = np.mean([np.mean(film.pressure(x, t, eps, delta, k)) for t in phase])
    ours = float(mean_overpressure(VIBRATION_UM, ROUGHNESS_UM))
    # The mean over x is exact to 1e-4 of the overpressure, because of the peaks under the ridges.
    return apart(round(float(mean), 4), round(1 + ours, 4))


def eq13() -> float:
    """Compare (13) with the mean of (11) over a period, by the trapezium rule."""
    import numpy as np

    from slipscale.stimuli.film import infinite_squeeze as film
    from slipscale.stimuli.film.squeeze_film import FINGER, mean_pressure

    eps, delta, k, x, _ = _film()
    phase = np.arange(512) * 2 * np.pi / 512
    mean = np.mean(film.pressure(x, phase, eps, delta, k), axis=1, keepdims=True)
    return apart(mean, mean_pressure(x * FINGER.contact_length_mm, VIBRATION_UM, ROUGHNESS_UM))


def eq15() -> float:
    """Return µ'/µ by (15) as printed, with P∞ - 1 relative to p0 and P_f in Pa."""
    from slipscale.stimuli.film.squeeze_film import FINGER, NORMAL_FORCE_N, mean_overpressure

    over = float(mean_overpressure(1.5, 0.6))
    return 1 - over / (NORMAL_FORCE_N / (FINGER.contact_length_mm * 1e-3) ** 2)


def eq43(*, mirrored: bool = False) -> float:
    """Compare (43), or (47) at -X, with K, for a Ψ² whose K1(X) follows from (46)."""
    from slipscale.stimuli.film import infinite_squeeze as film

    _, delta, k, x, _ = _film()
    constant, k1 = 0.4, 1.3
    # By (45) and (46), the slope is that of (7) plus K1'(X)·H̄².
    squared = film.psi_squared(x, k1, delta, k)
    mean = film.mean_thickness(x, delta, k)
    slope = squared * film.relative_slope(x, delta, k)
    slope = slope + film.slope_of_k1(x, constant, delta, k) * mean**2
    if mirrored:
        return apart(film.flux(squared, -slope, -x, delta, k), -constant)
    return apart(film.flux(squared, slope, x, delta, k), constant)


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
    9: Check(difference=eq9, reason="its square is (7) with K1 from (8)"),
    10: Check(
        difference=eq10,
        reason="the last line must be A² (1 + 1.5 ε²/A²), with A = 1 + δ cos(k/2), the ratio of "
        "the integrals by quadrature; (11) and (13) already use it. P is always relative to p0",
    ),
    11: Check(
        difference=eq11,
        reason="(P·H)² at the edge is the ratio of the integrals in (10), by quadrature",
    ),
    12: Check(
        difference=eq12, reason="mean of (11) over the contact and a period, to four decimals"
    ),
    13: Check(difference=eq13, reason="mean of (11) over a period by quadrature"),
    43: Check(difference=eq43, reason="constant for the Ψ² of (45) and (46)"),
    44: Check(difference=eq44, reason="numerical slope of the logarithm of (7)", also=(45,)),
    46: Check(difference=eq43, reason="K1' gives (43) with the constant K"),
    47: Check(difference=partial(eq43, mirrored=True), reason="(43) at -X, for an even Ψ²"),
}
ITEMS: Mapping[str, Callable[[], Outcome]] = {
    **items(CHECKS),
    "eq.15": item(
        eq15,
        "0.5",
        "µ'/µ",
        "as printed, P∞ - 1 has no unit and P_f is in Pa; 1 - p0·F_s/P_f, with the mean F_s of "
        "(12), gives 0.48, the paper's half (fig5.hr0.6.hvib1.5)",
        covers=("eq.15",),
    ),
}
FIGURES: Mapping[str, Callable[[], Figure]] = {}


if __name__ == "__main__":
    record(ITEMS, "film_equations.json")
