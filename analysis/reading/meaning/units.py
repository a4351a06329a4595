"""Convert between units that differ only in their prefix, and write units in names of columns."""

from __future__ import annotations

import re

from slipscale.faults import UserError

#: Prefixes with their powers of ten.
POWERS = "G 9, M 6, k 3, h 2, d -1, c -2, m -3, µ -6, μ -6, u -6, n -9, p -12"
PREFIXES = {"": 0} | {pair.split()[0]: int(pair.split()[1]) for pair in POWERS.split(", ")}
#: Units that can have prefixes. Other units (%, °C, dB) are not converted.
BASES = (
    *("m", "g", "s", "A", "K", "mol", "cd", "Hz", "N", "Pa", "J", "W", "V", "C", "F", "T", "lx"),
    *("lm", "L", "l", "cd/m²", "cd/m2", "m/s", "m/s²", "m/s2", "W/m²", "W/m2", "N/m", "mol/L"),
)


def factor(given: str, wanted: str) -> float:
    """Return the factor that converts a level from one unit to another.

    >>> factor("µPa", "Pa"), factor("m", "mm")
    (1e-06, 1000.0)

    Raises
    ------
    UserError
        If the units differ in more than their prefixes.
    """
    if given == wanted:
        return 1.0
    powers = dict(_readings(given))
    for base, power in _readings(wanted):
        if base in powers:
            return float(f"1e{powers[base] - power}")
    raise UserError(
        "unit '{given}' cannot be converted to {wanted}; expected the same unit with another "
        "prefix, such as Pa for µPa, or a converted column",
        given=given,
        wanted=wanted,
    )


def _readings(unit: str) -> list[tuple[str, int]]:
    """Return all interpretations of a unit as (base unit, power of ten); mm gives ("m", -3)."""
    return [
        (base, power)
        for prefix, power in PREFIXES.items()
        for base in BASES
        if prefix + base == unit
    ]


def column_name(name: str, unit: str) -> str:
    """Return a quantity's column name in output files.

    >>> column_name("sound pressure", "µPa")
    'sound_pressure_uPa'
    """
    text = f"{name}_{unit}".replace("µ", "u").replace("μ", "u").replace("/", "_per_")
    return re.sub(r"\W+", "_", text).strip("_")
