"""Model friction when asperities and the air film share the load.

**Not validated.** The model is based on observations by Wiertlewski, Friesen and Colgate (2016,
doi:10.1073/pnas.1603908113) and by Sednaoui, Vezzoli and others (2017,
doi:10.1109/TOH.2017.2671376), but no measured curve was available in numerical form. The parameters
are therefore ranges, and the result is a range (`band`). The equations are ours:

- **Contact**: the area increases with a power of the normal force; the pressure is p = F/A(F).
- **Asperities** carry the pressure p_ref·exp((u0 - u)/l) at a gap u (Persson 2007,
  doi:10.1103/PhysRevLett.99.125502). u0 is the mean gap at rest under p_ref, which is the pressure
  in equation (14).
- **Bounce**: the amplitude of the gap is a multiple of the plate's amplitude, because the skin also
  moves (Friesen, Wiertlewski and Colgate 2016, doi:10.1109/HAPTICS.2016.7463172).
- **Film**: the mean overpressure is computed from Reynolds' equation (3) for a flat film with this
  mean gap.
- **Equilibrium**: at the mean gap, the pressures of asperities and film add up to p on average. By
  Coulomb's law, relative friction is the fraction of the load that asperities carry; it is 1
  without vibration.

For stiff asperities (l → 0) without bounce, the gap is h_r + h_vib, and the model is equation (15)
for a flat finger. The finger's speed is not modelled.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache
from itertools import product

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
_CLOSED_FORM_SIGMA = 1e4  # above it, the error of the closed form is at most 1.5 %
_GAP_TOLERANCE_UM = 1e-4
_UNITS = {
    "contact_area_cm2": "cm²",
    "asperity_length_um": "µm",
    "rest_gap_um": "µm",
    "leak_length_mm": "mm",
    "bounce": "(no unit)",
}
# Smallest distance between skin and plate during a period, as a fraction of the gap's amplitude.
# Without any distance, the film's pressure is infinite.
_LEAST_CLEARANCE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class Skin:
    """Properties of a fingertip on the plate.

    Parameters
    ----------
    contact_area_cm2 : float
        Contact area at 0.5 N in cm².
    area_exponent : float
        Exponent of the contact area as a function of force: 0 for a constant area (as in the
        paper), 2/3 for a sphere (Hertz).
    asperity_length_um : float
        Increase in the gap, in µm, over which the pressure of the asperities falls to 1/e.
    rest_gap_um : float
        Mean gap in µm without vibration, at the pressure `REFERENCE_PA`.
    leak_length_mm : float
        Length in mm of the path along which air escapes.
    bounce : float
        Ratio of the gap's amplitude to the plate's amplitude; 1 if the skin does not move.

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


# Ends of all ranges. Sources: area, 1 cm² in Table I of Biet et al. (2007) ± 30 %; asperities, half
# of the roughness of 0.4 to 1.6 µm in Table I (Persson: of the order of half the rms height); leak,
# from one ridge period in Table I to the whole contact. Area exponent, gap at rest and bounce are
# assumptions.
SLIPPERY = Skin(
    contact_area_cm2=1.3,  # 1 cm² in Table I, ± 30 % (assumed)
    area_exponent=2 / 3,  # Hertz; half of Hertz (assumed)
    asperity_length_um=0.2,  # half of the roughness in Table I (assumed)
    rest_gap_um=1.0,  # assumed
    leak_length_mm=10.0,  # the whole contact; `GRIPPY`: one ridge period (Table I)
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
    """Interpolate geometrically between `SLIPPERY` (share 0) and `GRIPPY` (share 1)."""
    if not 0 <= share <= 1:
        raise UserError("share must be between 0 and 1, but is {share}", share=repr(share))
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
        Mean gap over a period in µm.
    film_share : float
        Fraction of the load that the film carries, from 0 to 1.
    """

    mean_gap_um: float
    film_share: float

    @property
    def relative_friction(self) -> float:
        """Relative friction µ'/µ, which equals the fraction of the load carried by asperities."""
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
    """Compute the mean gap at which asperities and film together carry the load of the finger.

    Parameters
    ----------
    amplitude_um_peak : float
        Vibration amplitude of the plate in µm **peak**.

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

    # The mean of exp(-(swing/length)·cos) over a period is the Bessel function I0(swing/length).
    # `i0e` multiplies it by exp(-swing/length).
    bounced = float(np.log(i0e(swing / length)))

    def excess(gap_um: float) -> float:
        """Return the log ratio of supported to applied load, which decreases with the gap."""
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
    """Return the minimum and maximum relative friction over the range of skin properties.

    Parameters
    ----------
    amplitude_um_peak : float
        Vibration amplitude of the plate in µm **peak**.
    """
    # Friction rises with the gap at rest and falls with the leak and the bounce. The area, its
    # exponent and the asperity length can raise or lower friction, so all combinations of their
    # extreme values are compared. At 0.5 N, the exponent has no effect.
    ends = (SLIPPERY, GRIPPY)
    exponents = {skin.area_exponent for skin in ends if normal_force_n != NORMAL_FORCE_N} or {0.0}
    found = [
        solve(
            replace(
                skin,
                contact_area_cm2=area.contact_area_cm2,
                asperity_length_um=asperities.asperity_length_um,
                area_exponent=exponent,
            ),
            amplitude_um_peak,
            frequency_hz=frequency_hz,
            normal_force_n=normal_force_n,
        ).relative_friction
        for skin, area, asperities in product(ends, repeat=3)
        for exponent in exponents
    ]
    return min(found), max(found)
