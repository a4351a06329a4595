"""Assumed growth of sensation with the stimulus level, for each physical quantity.

Biet 2007 reports sensations for four amplitudes of one plate (`population`). For other quantities,
we assume that the lowest and highest levels of a study feel like those in Biet 2007, and that
people differ as much as the participants of Biet 2007. The table `GROWTH` specifies how sensation
grows between the lowest and the highest level.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipscale.experiments.participants.simulated_people.population import (
    AMPLITUDE_UM_PP,
    MEAN_SENSATION,
    SD_SENSATION,
    Population,
)
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.study.factors import Factor
    from slipscale.experiments.study.model import Study
    from slipscale.stimuli.quantity import Quantity

STEPS = 12
# With equal noise on both impressions, 75 % of forced choices are correct at a difference of this
# many noise standard deviations.
D_AT_75_PERCENT = 0.6745


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """Growth of sensation with the stimulus level.

    Parameters
    ----------
    exponent : float
        Exponent of a power function of the level's position in the study's range (0 to 1). Unused
        if ``weber`` is given.
    weber : float or None
        Weber fraction: the smallest relative change that is detected in 75 % of forced choices. If
        ``weber`` is given, sensation grows with the logarithm of the level.
    falls : bool
        Whether sensation decreases with the level.
    """

    exponent: float = 1.0
    weber: float | None = None
    falls: bool = False


#: Growth of sensation, keyed by the judged attribute and by the level's name or unit. The first
#: match applies; "" matches everything.
GROWTH = {
    # Roughness of square gratings decreases with the period over the range studied, with a Weber
    # fraction of 14 %: Saleem, Yilmaz and Basdogan 2020 (abstract).
    ("roughness", "spatial period"): Growth(weber=0.14, falls=True),
    ("", "spatial period"): Growth(weber=0.14),
    # Electrovibration: the electrostatic force on the finger, and therefore friction, grows with
    # the square of the voltage (Bau and others 2010; Meyer and others 2013; cited from memory). We
    # found no published exponent for the sensation.
    ("", "V"): Growth(exponent=2.0),
    # For a vibrating contactor, the exponent is about 0.89 up to 350 Hz (Verrillo 1970, IEEE Trans.
    # Man-Mach. Syst. 11; abstract). According to Stevens 1968 (Percept. Psychophys. 3, 223-228;
    # abstract), the exponent is 1.0 at 60 Hz and half its maximum near 250 Hz.
    ("", "m/s²"): Growth(exponent=0.89),
}
#: Any other quantity: sensation is proportional to the level (our assumption).
OTHER = Growth()


def growth_of(quantity: Quantity) -> Growth:
    """Return the assumed growth of sensation for a quantity."""
    keys = [
        (judged, of) for judged in (quantity.judged, "") for of in (quantity.name, quantity.unit)
    ]
    return next((GROWTH[key] for key in keys if key in GROWTH), OTHER)


def _effects(factors: Sequence[Factor]) -> dict[str, object]:
    return {
        "effects": tuple((f.name, level, by) for f in factors for level, by in f.simulated.items()),
        "growths": tuple(
            (f.name, level, by) for f in factors for level, by in f.simulated_growth.items()
        ),
        "effect_sds": tuple((f.name, f.simulated_sd) for f in factors if f.simulated_sd),
    }


def people_for(study: Study, population: Population | None = None) -> Population:
    """Return the simulated population for a pilot, with sensation curves in the study's quantity.

    Raises
    ------
    UserError
        If the population's curve is defined for a quantity other than the study's.
    """
    people, quantity = population or Population(), study.quantity
    if not (people.effects or people.growths or people.effect_sds):
        people = people.model_copy(update=_effects(study.factors))
    unit = "" if quantity.in_um_pp and not study.vary else quantity.unit_in_full
    if people.unit == unit and not study.simulated:
        return people
    if people.unit or people.levels != AMPLITUDE_UM_PP:
        raise UserError(
            "population '{people_name}': its levels are in {unit}, but the study's are in "
            "{unit_in_full}; expected a population in the study's unit",
            people_name=people.name,
            unit=people.unit or "µm peak to peak",
            unit_in_full=quantity.unit_in_full,
        )
    import numpy as np

    growth, stated = growth_of(quantity), study.simulated
    if stated:
        growth = replace(growth, weber=stated.weber, exponent=stated.exponent)
    low, high = study.range_level
    shares = [step / STEPS for step in range(STEPS + 1)]
    levels = [low + share * (high - low) for share in shares]
    grown = [share**growth.exponent for share in shares]
    noise = people.noise
    if growth.weber is not None:
        span = math.log(high / low)
        levels = [low * math.exp(share * span) for share in shares]
        noise = math.log1p(growth.weber) / span * (MEAN_SENSATION[-1] - MEAN_SENSATION[0])
        noise /= D_AT_75_PERCENT
        grown = shares
    if growth.falls or quantity.falls:
        grown = [1 - share for share in grown]
    first, last = MEAN_SENSATION[0], MEAN_SENSATION[-1]
    means = tuple(first + (last - first) * share for share in grown)
    return people.model_copy(
        update={
            "unit": unit,
            "levels": tuple(levels),
            "mean_sensation": means,
            "sd_sensation": tuple(float(np.interp(m, MEAN_SENSATION, SD_SENSATION)) for m in means),
            "noise": noise,
        }
    )
