"""Compute the squeeze film in closed form, equations (1) to (15), for infinite squeeze numbers.

**Vibration amplitudes are peak amplitudes** (`slipscale.stimuli.surface` converts peak-to-peak
amplitudes). Equation numbers refer to Section II of Biet, Giraud and Lemaire-Semail (2007).
Corrections of printed equations are documented in the functions that use them.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt

from slipscale.stimuli.film.infinite_squeeze import edge_squared, mean_thickness
from slipscale.stimuli.quantities import MICRO, MILLI, Array, not_negative, positive

SQUEEZE_NUMBER_MIN = 10.0  # Section II-C: "larger than 10"; see docs/explanation/squeeze-film.md
_NODES = 96  # Gauss-Legendre nodes over half a ridge; error 1e-12 at h_r = 0.01 µm, h_vib = 5 µm


class ClosedFormWarning(UserWarning):
    """Warning that the squeeze number is too small for the closed form."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Finger:
    """Fingertip on the plate (Table I of the paper).

    Parameters
    ----------
    ridge_amplitude_um : float
        Amplitude h_e of the epidermal ridges in µm (half the ridge height); 0 for a flat finger.
    ridge_period_um : float
        Period L of the ridges, µm.
    contact_length_mm : float
        Side length l0 of the square contact, mm.
    """

    ridge_amplitude_um: float = 50.0
    ridge_period_um: float = 350.0
    contact_length_mm: float = 10.0

    def __post_init__(self) -> None:
        not_negative("finger: ridge_amplitude_um", self.ridge_amplitude_um, "µm")
        positive("finger: ridge_period_um", self.ridge_period_um, "µm")
        positive("finger: contact_length_mm", self.contact_length_mm, "mm")

    @property
    def wave_number(self) -> float:
        """Dimensionless wave number k = 2π l0/L of equation (2)."""
        return 2 * np.pi * self.contact_length_mm * MILLI / (self.ridge_period_um * MICRO)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gas:
    """Gas in the film (Table I of the paper: air at 20 °C).

    Parameters
    ----------
    viscosity_pa_s : float
        Dynamic viscosity η, Pa·s.
    pressure_pa : float
        Ambient pressure p0, Pa.
    """

    viscosity_pa_s: float = 1.85e-5
    pressure_pa: float = 1e5

    def __post_init__(self) -> None:
        positive("gas: viscosity_pa_s", self.viscosity_pa_s, "Pa·s")
        positive("gas: pressure_pa", self.pressure_pa, "Pa")


FINGER, AIR = Finger(), Gas()
ROUGHNESS_UM = (0.4, 0.8, 1.2, 1.6)  # h_r of Table I
NORMAL_FORCE_N = 0.5  # Section II-C, mean force of an exploring finger


@dataclass(frozen=True, slots=True, kw_only=True)
class Friction:
    """Effect of the film on friction; all arrays have the same shape.

    Parameters
    ----------
    relative_friction : ndarray
        Relative friction µ'/µ of equation (15). **If it is negative, the film carries more than the
        finger's force, and the finger levitates.** Values are not clipped.
    overpressure : ndarray
        F_s of equation (12): the mean of p/p0 - 1 over the contact and the period.
    squeeze_number : ndarray
        Squeeze number, equation (4).
    """

    relative_friction: Array
    overpressure: Array
    squeeze_number: Array

    @property
    def levitates(self) -> npt.NDArray[np.bool_]:
        """Whether the film carries more than the force of the finger, element by element."""
        return self.relative_friction < 0

    @property
    def closed_form_holds(self) -> npt.NDArray[np.bool_]:
        """Whether the squeeze number is at least 10, the paper's criterion (Section II-C)."""
        return self.squeeze_number >= SQUEEZE_NUMBER_MIN


def gap(
    amplitude_um_peak: npt.ArrayLike, roughness_um: npt.ArrayLike, finger: Finger = FINGER
) -> tuple[Array, Array, Array]:
    """Return the mean gap in µm, and ε and δ of equation (2), H = 1 + ε cos T + δ cos kX.

    Raises
    ------
    UserError
        If the amplitude is negative or the roughness is not positive. Without roughness, the
        minimum of the gap is zero, and the pressure diverges if the plate vibrates.
    """
    vibration = not_negative("amplitude_um_peak", amplitude_um_peak, "µm peak")
    roughness = positive("roughness_um", roughness_um, "µm")
    mean = vibration + roughness + finger.ridge_amplitude_um
    return mean, vibration / mean, finger.ridge_amplitude_um / mean


def film_thickness_um(
    position_mm: npt.ArrayLike,
    phase_rad: npt.ArrayLike,
    amplitude_um_peak: float,
    roughness_um: float,
    finger: Finger = FINGER,
) -> Array:
    """Return the film thickness in µm by equation (1), where x = 0 is the middle of a groove.

    Parameters
    ----------
    position_mm, phase_rad : array_like
        Position x in mm, and phase ω0·t of the vibration; their shapes must be broadcastable.
    """
    mean, depth, ridge = gap(amplitude_um_peak, roughness_um, finger)
    x = 2 * np.pi * np.asarray(position_mm) * MILLI / (finger.ridge_period_um * MICRO)
    return np.asarray(mean * (1 + depth * np.cos(phase_rad) + ridge * np.cos(x)))


def squeeze_number(
    frequency_hz: npt.ArrayLike,
    amplitude_um_peak: npt.ArrayLike,
    roughness_um: npt.ArrayLike,
    finger: Finger = FINGER,
    gas: Gas = AIR,
) -> Array:
    """Return the squeeze number by equation (4), corrected to l0² (the paper prints l0).

    >>> round(float(squeeze_number(30_500, 1.15, 0.6)), 2)  # printed: 15.9, Section IV-A
    15.89
    """
    omega = 2 * np.pi * positive("frequency_hz", frequency_hz, "Hz")
    mean = gap(amplitude_um_peak, roughness_um, finger)[0] * MICRO
    length = finger.contact_length_mm * MILLI
    return np.asarray(12 * gas.viscosity_pa_s * omega * length**2 / (gas.pressure_pa * mean**2))


def mean_pressure(
    position_mm: npt.ArrayLike,
    amplitude_um_peak: npt.ArrayLike,
    roughness_um: npt.ArrayLike,
    finger: Finger = FINGER,
) -> Array:
    """Return the mean of p/p0 over a period for an infinite squeeze number by equation (13).

    P is always normalised by p0. Positions are in mm from the middle of the contact.
    """
    _, eps, delta = gap(amplitude_um_peak, roughness_um, finger)
    x = np.asarray(position_mm, dtype=float) / finger.contact_length_mm
    thickness = mean_thickness(x, delta, finger.wave_number)
    return np.asarray(_edge(eps, delta, finger) * thickness / np.sqrt(thickness**2 - eps**2))


def mean_overpressure(
    amplitude_um_peak: npt.ArrayLike,
    roughness_um: npt.ArrayLike,
    finger: Finger = FINGER,
) -> Array:
    """Return F_s of equation (12): the mean of p/p0 - 1 for an infinite squeeze number.

    The integral over a ridge uses the eccentric anomaly ψ, because the integrand's sharp peak under
    a ridge is smooth in ψ: 1 - δ cos φ = (1 - δ²)/(1 + δ cos ψ), with φ = 0 at the top of the
    ridge.
    """
    _, eps, delta = np.broadcast_arrays(*gap(amplitude_um_peak, roughness_um, finger))
    # From a groove (X = 0) to the edge: complete half-periods, and a remainder.
    half_periods, rest = divmod(finger.wave_number / 2, np.pi)
    from_groove = half_periods % 2 == 0
    whole = _ridge_integral(np.full_like(delta, np.pi), eps, delta)
    angle = np.pi - rest if from_groove else rest
    upto = _ridge_integral(_eccentric(angle, delta), eps, delta)
    part = whole - upto if from_groove else upto
    excess = (half_periods * whole + part) / (finger.wave_number / 2)
    return np.asarray(_edge(eps, delta, finger) * (1 + excess) - 1)


def relative_friction(
    amplitude_um_peak: npt.ArrayLike,
    roughness_um: npt.ArrayLike,
    frequency_hz: npt.ArrayLike,
    *,
    normal_force_n: npt.ArrayLike = NORMAL_FORCE_N,
    finger: Finger = FINGER,
    gas: Gas = AIR,
) -> Friction:
    """Return friction relative to the plate at rest, from equation (15) as 1 - p0·F_s/P_f.

    F_s is the mean over space and time, which differs from the printed P∞ - 1. P_f = F_f/l0² is
    equation (14). All numeric arguments are broadcast against each other.

    Parameters
    ----------
    amplitude_um_peak : array_like
        Vibration amplitude h_vib in µm **peak**.
    roughness_um : array_like
        Average roughness h_r of the plate, µm.
    frequency_hz : array_like
        Vibration frequency, which affects only the validity of the closed form.
    normal_force_n : array_like
        Force F_f of the finger on the plate, N.

    Warns
    -----
    ClosedFormWarning
        If a squeeze number is below 10 while the plate vibrates.

    Examples
    --------
    >>> round(float(relative_friction(1.5, 0.6, 40_000).relative_friction), 2)  # printed: half
    0.48
    """
    force = positive("normal_force_n", normal_force_n, "N")
    number = squeeze_number(frequency_hz, amplitude_um_peak, roughness_um, finger, gas)
    over = mean_overpressure(amplitude_um_peak, roughness_um, finger)
    number, over, force = np.broadcast_arrays(number, over, force)
    least = float(np.min(number[over > 0], initial=np.inf))
    if least < SQUEEZE_NUMBER_MIN:
        warnings.warn(
            f"the squeeze number is {least:.3g}; below {SQUEEZE_NUMBER_MIN:g}, the closed form "
            "overestimates the pressure of the film; use slipscale.stimuli.film.reynolds, which "
            "is valid for any squeeze number",
            ClosedFormWarning,
            stacklevel=2,
        )
    return friction_from(over, number, force, finger, gas)


def friction_from(
    overpressure: Array,
    number: Array,
    normal_force_n: npt.ArrayLike,
    finger: Finger,
    gas: Gas,
) -> Friction:
    """Return the friction for a mean overpressure relative to p0 by equations (14) and (15)."""
    finger_pressure = positive("normal_force_n", normal_force_n, "N") / (
        (finger.contact_length_mm * MILLI) ** 2
    )
    return Friction(
        relative_friction=1 - gas.pressure_pa * overpressure / finger_pressure,
        overpressure=overpressure,
        squeeze_number=number,
    )


def _edge(eps: Array, delta: Array, finger: Finger) -> Array:
    """Return Ψ of equations (9) and (10) at the edge, divided by the mean thickness at the edge."""
    k = finger.wave_number
    return np.asarray(np.sqrt(edge_squared(eps, delta, k)) / mean_thickness(0.5, delta, k))


def _eccentric(angle: float, delta: Array) -> Array:
    """Return the eccentric anomaly ψ for an angle φ in [0, π] from the top of a ridge."""
    return np.asarray(
        2
        * np.arctan2(np.sqrt(1 + delta) * np.sin(angle / 2), np.sqrt(1 - delta) * np.cos(angle / 2))
    )


def _ridge_integral(psi_end: Array, eps: Array, delta: Array) -> Array:
    """Integrate 1/sqrt(1 - ε²/H²) - 1 over φ, from the top of a ridge to eccentric anomaly ψ."""
    nodes, weights = _quadrature()
    half = psi_end[..., None] / 2
    psi = half * (1 + nodes)
    bulge = 1 + delta[..., None] * np.cos(psi)
    shrink = 1 - delta[..., None] ** 2
    ratio = (eps[..., None] * bulge / shrink) ** 2
    excess = 1 / np.sqrt(1 - ratio) - 1
    return np.asarray(np.sum(weights * half * excess * np.sqrt(shrink) / bulge, axis=-1))


@cache
def _quadrature() -> tuple[Array, Array]:
    """Return the nodes and weights for Gauss-Legendre quadrature (cached)."""
    return np.polynomial.legendre.leggauss(_NODES)
