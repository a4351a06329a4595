"""Convert between names of fields in the code and names in files that give levels in µm.

Names in the code do not contain a unit, because a level can be a value of any quantity.

===============  ===================  ===================  ==============================
in the code      in a file in µm      in a file in volts   conversion
===============  ===================  ===================  ==============================
standard_level   standard_um_pp       standard_v_peak      `in_code`, `in_um`
level            amplitude_um_pp      voltage_v_peak       and `Quantity.key` from µm
levels           amplitudes_um_pp     voltages_v_peak      to any other
===============  ===================  ===================  ==============================
"""

from __future__ import annotations

import re
from functools import cache

#: Names in files with levels in µm, and in the code. The first match applies. For placeholders,
#: see `PLACES`.
NAMES = (
    ("{interval}amplitude{when}_um_pp", "{interval}level{when}"),
    ("amplitudes_um_pp", "levels"),
    ("level_um_pp", "track_level"),  # distance of an adaptive track's level from the standard
    ("tolerance_um", "deviation_level"),
    ("comparisons_um_pp", "comparison_levels"),
    ("references_um_pp", "reference_levels"),
    ("{what}_um_pp", "{what}_level"),
)
PLACES = {
    "interval": r"(?P<interval>(?:interval\d+_)?)",
    "when": "(?P<when>(?:_before|_readback)?)",
    "what": r"(?P<what>\w+)",
}


def in_code(name: str) -> str:
    """Convert a name used in files with levels in µm to the name used in the code.

    >>> in_code("standard_um_pp"), in_code("amplitude_before_um_pp"), in_code("trial")
    ('standard_level', 'level_before', 'trial')
    """
    return _renamed(name, to_code=True)


def in_um(name: str) -> str:
    """Convert a name used in the code to the name in files with levels in µm (see `in_code`).

    >>> in_um("levels"), in_um("interval2_level"), in_um("highest_level")
    ('amplitudes_um_pp', 'interval2_amplitude_um_pp', 'highest_um_pp')
    """
    return _renamed(name, to_code=False)


@cache
def _renamed(name: str, *, to_code: bool) -> str:
    for in_file, inside in NAMES:
        old, new = (in_file, inside) if to_code else (inside, in_file)
        if found := re.fullmatch(old.format(**PLACES), name):
            return new.format(**found.groupdict())
    return name
