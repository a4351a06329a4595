"""Shared load: a second friction model, in which asperities and film carry the finger together.

**Not validated.** It follows the observations of Wiertlewski, Friesen and Colgate (2016,
doi:10.1073/pnas.1603908113) and of Sednaoui, Vezzoli and others (2017,
doi:10.1109/TOH.2017.2671376); no measured curve was available as numbers. Its parameters are
therefore ranges, and its result is a band (`band`), never a point. The equations are ours:

- **Contact**: the area grows with a power of the normal force; the pressure is p = F/A(F).
- **Asperities** carry p_ref·exp((u0 - u)/l) at a gap u (Persson 2007,
  doi:10.1103/PhysRevLett.99.125502). u0 is the mean gap at rest under p_ref, the pressure of
  eq. (14).
- **Bounce**: the gap oscillates with a multiple of the plate's amplitude, because the skin also
  moves (Friesen, Wiertlewski and Colgate 2016, doi:10.1109/HAPTICS.2016.7463172).
- **Film**: the mean overpressure from Reynolds' equation (3) for a flat film with that mean gap.
- At the mean gap, asperities and film, each averaged over a period, together carry p. Relative
  friction is the asperities' fraction of the load (Coulomb's law), 1 without vibration.

For stiff asperities (l → 0) without bounce, the gap is h_r + h_vib: equation (15) for a flat
finger. Speed is not modelled.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq
from scipy.special import i0e

from slipscale.faults import UserError
from slipscale.stimuli.film.periodic_film import Resolution, periodic_state
from slipscale.stimuli.film.squeeze_film import (
    AIR,
    FINGER,
    NORMAL_FORCE_N,
    Finger,
    Gas,
    mean_overpressure,
    squeeze_number,
)
from slipscale.stimuli.quantities import MILLI, not_negative, positive

NOT_VALIDATED = "shared load, not validated"
REFERENCE_PA = NORMAL_FORCE_N / (FINGER.contact_length_mm * MILLI) ** 2
_SQUARE_CM_M2 = 1e-4
_FLAT = Resolution(cells_min=24, instants=13)  # within 0.2 % up to ε = 0.6, 4 % at 0.95
_CLOSED_FORM_SIGMA = 1e4  # beyond, a flat film is within 1.5 % of its closed form
_GAP_TOLERANCE_UM = 1e-4
_UNITS = {
    "contact_area_cm2": "cm²",
    "asperity_length_um": "µm",
    "rest_gap_um": "µm",
    "leak_length_mm": "mm",
    "bounce": "(no unit)",
}
_LEAST_CLEARANCE = 1e-3  # of the oscillation; below it, the film's pressure is unbounded


@dataclass(frozen=True, slots=True, kw_only=True)
class Skin:
    """A fingertip on the plate.

    Parameters
    ----------
    contact_area_cm2 : float
        Contact area at 0.5 N, cm².
    area_exponent : float
        Exponent of the area's growth with force: 0 for none (2007), 2/3 for a sphere (Hertz).
    asperity_length_um : float
        Increase of the gap over which the asperities' pressure falls to 1/e, µm.
    rest_gap_um : float
        Mean gap without vibration under `REFERENCE_PA`, µm.
    leak_length_mm : float
        Length across which air escapes, mm.
    bounce : float
        Amplitude of the gap relative to that of the plate: 1 if the skin is at rest.

    Raises
    ------
    UserError
        If a value is out of range.
    """

    contact_area_cm2: float
    area_exponent: float
    asperity_length_um: float
    rest_gap_um: float
    leak_length_mm: float
    bounce: float

    def __post_init__(self) -> None:
        for name, unit in _UNITS.items():
            positive(f"skin: {name}", getattr(self, name), unit)
        not_negative("skin: area_exponent", self.area_exponent, "(no unit)", maximum=1)


# The ends of every range; all skins are between them (tests/stimuli/test_shared_load.py).
# Sources: area, 1 cm² in Table I ± 30 %; asperities, half of Table I's roughness of 0.4 to
# 1.6 µm (Persson: of the order of half the rms height); leak, from one ridge period in Table I
# to the whole contact. Exponent, rest gap and bounce are assumptions.
# The ends of each range; Table I is that of Biet and others (2007).
SLIPPERY = Skin(
    contact_area_cm2=1.3,  # Table I's 1 cm², ± 30 % (assumed)
    area_exponent=2 / 3,  # Hertz; half of it (assumed)
    asperity_length_um=0.2,  # half of Table I's roughness (assumed)
    rest_gap_um=1.0,  # assumed
    leak_length_mm=10.0,  # the whole contact; one ridge of Table I
    bounce=1.2,  # assumed; Friesen and others (2016) observed both phases
)
GRIPPY = Skin(
    contact_area_cm2=0.7,
    area_exponent=1 / 3,
    asperity_length_um=0.8,
    rest_gap_um=3.0,
    leak_length_mm=0.35,
    bounce=0.8,
)


def skin_between(share: float) -> Skin:
    """Return a skin within the ranges: `SLIPPERY` at 0, `GRIPPY` at 1, geometric means between."""
    if not 0 <= share <= 1:
        raise UserError(f"share is {share!r}, expected 0 to 1")
    return Skin(
        **{
            field.name: float(
                getattr(SLIPPERY, field.name) ** (1 - share) * getattr(GRIPPY, field.name) ** share
            )
            for field in fields(Skin)
        }
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Shared:
    """Distribution of the finger's load between asperities and film.

    Parameters
    ----------
    mean_gap_um : float
        Gap, mean over a period, µm.
    film_share : float
        Fraction of the load that the film carries, 0 to 1.
    """

    mean_gap_um: float
    film_share: float

    @property
    def relative_friction(self) -> float:
        """µ'/µ, the fraction of the load that the asperities carry."""
        return 1 - self.film_share


@lru_cache(maxsize=4096)
def solve(
    skin: Skin,
    amplitude_um_peak: float,
    *,
    frequency_hz: float = 30_500.0,
    normal_force_n: float = NORMAL_FORCE_N,
    gas: Gas = AIR,
) -> Shared:
    """Return the mean gap at which asperities and film carry the finger.

    Parameters
    ----------
    amplitude_um_peak : float
        Vibration amplitude of the plate, µm **peak**.

    Raises
    ------
    UserError
        If a value is out of range.
    ReynoldsDiverged
        See `slipscale.stimuli.film.periodic_film.periodic_state`.
    """
    swing = skin.bounce * float(not_negative("amplitude_um_peak", amplitude_um_peak, "µm peak"))
    force = float(positive("normal_force_n", normal_force_n, "N"))
    area = skin.contact_area_cm2 * _SQUARE_CM_M2
    pressure = force / (area * (force / NORMAL_FORCE_N) ** skin.area_exponent)
    length = skin.asperity_length_um
    rest = skin.rest_gap_um - length * float(np.log(pressure / REFERENCE_PA))
    if swing == 0:
        return Shared(mean_gap_um=rest, film_share=0.0)

    def film_pa(gap_um: float) -> float:
        finger = Finger(ridge_amplitude_um=0.0, contact_length_mm=skin.leak_length_mm)
        roughness = gap_um - swing
        sigma = float(squeeze_number(frequency_hz, swing, roughness, finger, gas))
        if sigma > _CLOSED_FORM_SIGMA:
            return gas.pressure_pa * float(mean_overpressure(swing, roughness, finger))
        state = periodic_state(sigma, swing / gap_um, 0.0, finger.wave_number, resolution=_FLAT)
        return gas.pressure_pa * state.overpressure

    # The mean of exp(-(swing/length)·cos) over a period is Bessel's I0, scaled here.
    bounced = float(np.log(i0e(swing / length)))

    def excess(gap_um: float) -> float:
        """Logarithm of the carried load over the applied one; it decreases with the gap."""
        asperities = (rest - gap_um + swing) / length + bounced
        return float(np.logaddexp(asperities, np.log(film_pa(gap_um) / pressure)))

    low, high = swing * (1 + _LEAST_CLEARANCE), rest + 2 * swing + length
    while excess(high) > 0:
        high *= 2
    gap = low if excess(low) <= 0 else brentq(excess, low, high, xtol=_GAP_TOLERANCE_UM)
    return Shared(mean_gap_um=gap, film_share=min(1.0, film_pa(gap) / pressure))


def band(
    amplitude_um_peak: float,
    *,
    frequency_hz: float = 30_500.0,
    normal_force_n: float = NORMAL_FORCE_N,
) -> tuple[float, float]:
    """Return the minimum and maximum of relative friction over the ranges of `Skin`.

    Parameters
    ----------
    amplitude_um_peak : float
        Vibration amplitude of the plate, µm **peak**.
    """
    # Friction increases from SLIPPERY to GRIPPY in every range except the exponent: a larger one
    # lowers the pressure above 0.5 N, raises it below, and has no effect at 0.5 N.
    ends = (SLIPPERY, GRIPPY)
    exponents = {skin.area_exponent for skin in ends if normal_force_n != NORMAL_FORCE_N} or {0.0}
    found = [
        solve(
            replace(skin, area_exponent=exponent),
            amplitude_um_peak,
            frequency_hz=frequency_hz,
            normal_force_n=normal_force_n,
        ).relative_friction
        for skin in ends
        for exponent in exponents
    ]
    return min(found), max(found)
