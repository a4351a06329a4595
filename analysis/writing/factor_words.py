"""Format names and levels of factors, such as "180 Hz" for level 180 of ``frequency_hz``."""

from __future__ import annotations

#: End of a factor's name -> unit; the longest that fits applies.
UNITS = {
    "_mm_s": "mm/s",
    "_m_s": "m/s",
    "_um_pp": "µm p-p",
    "_v_peak": "V peak",
    "_khz": "kHz",
    "_hz": "Hz",
    "_ms": "ms",
    "_s": "s",
    "_um": "µm",
    "_mm": "mm",
    "_deg": "°",
    "_n": "N",
    "_v": "V",
}
#: Name of a stimulus parameter that is not a noun -> noun.
NOUNS = {"from": "initial level"}


def factor_name(factor: str) -> str:
    """Return the name of a factor without its unit.

    >>> factor_name("finger_speed_mm_s"), factor_name("hand"), factor_name("from_um_pp")
    ('finger speed', 'hand', 'initial level')
    """
    name = factor.removesuffix(_end(factor)).replace("_", " ")
    return NOUNS.get(name, name)


def factor_level(factor: str, level: str) -> str:
    """Format a factor's level with its unit.

    >>> factor_level("frequency_hz", "180"), factor_level("hand", "left")
    ('180 Hz', 'left')
    """
    return f"{level} {UNITS.get(_end(factor), '')}".rstrip()


def _end(factor: str) -> str:
    return max((end for end in UNITS if factor.endswith(end)), key=len, default="")
