"""Convert the names of levels between the code and files, where they contain quantity and unit.

Files are journals, tables, sidecars, JSON, study files and plate files.

===================  ==================  =================
in the code          in a file in µm     in a file in volts
===================  ==================  =================
level                amplitude_um_pp     voltage_v_peak
levels               amplitudes_um_pp    voltages_v_peak
standard_level       standard_um_pp      standard_v_peak
===================  ==================  =================
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

#: Suffix added to names used in the code that are found in a file, so that they are unknown.
UNKNOWN = "?"
#: Names in the code and in files. The first match applies. For placeholders, see `PLACES`.
NAMES = (
    # Never levels: the drive, even in a study in V peak, and the loudness of masking noise.
    ("drive_voltage_v_peak", "drive_voltage_v_peak"),
    ("noise_level", "noise_level"),
    ("{interval}level", "{interval}{column}"),
    ("{interval}level{when}", "{interval}{noun}{when}_{unit}"),
    ("levels", "{nouns}_{unit}"),
    ("track_level", "level_{unit}"),  # distance of an adaptive track's level from the standard
    ("deviation_level", "tolerance_{tolerance}"),
    ("left_out_levels", "left_out_{unit}"),
    ("{several}_levels", "{several}s_{unit}"),
    ("{what}_level{end}", "{what}_{unit}{end}"),
)
#: Other names in results.
RESULTS = {"of_level": "noun", "of_levels": "nouns", "unit_of_level": "unit"}
PLACES = {
    "interval": r"(?P<interval>(?:interval\d+_)?)",
    "when": r"(?P<when>_before|_readback)",
    "several": "(?P<several>comparison|reference)",
    "what": r"(?P<what>\w+)",
    "end": r"(?P<end>(?:_before|_low|_high)?)",
}


class Words(NamedTuple):
    """The parts of names that depend on the quantity."""

    column: str
    noun: str
    nouns: str
    unit: str
    tolerance: str


class Names(dict[str, str]):
    """Names that have been converted once; any other name is converted when it is looked up."""

    def __init__(self, convert: Callable[[str], str]) -> None:
        super().__init__()
        self._convert = convert

    def __missing__(self, name: str) -> str:
        found = self[name] = self._convert(name)
        return found


@cache
def in_file(words: Words) -> Names:
    """Return the names in files with levels in a quantity, keyed by name in the code.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE, made_by_plate
    >>> names = PLATE_AMPLITUDE.in_file
    >>> names["levels"], names["interval2_level"], names["highest_level"], names["trial"]
    ('amplitudes_um_pp', 'interval2_amplitude_um_pp', 'highest_um_pp', 'trial')
    >>> made_by_plate("acceleration", "m/s²", "RMS").in_file["standard_level"]
    'standard_m_s2_rms'
    """
    parts: dict[str, str] = words._asdict()

    def convert(name: str) -> str:
        if name in RESULTS:
            return parts[RESULTS[name]]
        for code, file in NAMES:
            if found := re.fullmatch(code.format(**PLACES), name):
                return file.format(**parts, **found.groupdict())
        return name

    return Names(convert)


def path_in_file(path: str, names: Names) -> str:
    """Convert the names in the path to a result; ``levels`` in a path are levels of a factor.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE
    >>> path_in_file("matching.bias_level.mean", PLATE_AMPLITUDE.in_file)
    'matching.bias_um_pp.mean'
    """
    return ".".join(part if part == "levels" else names[part] for part in path.split("."))


@cache
def in_code(words: Words) -> Names:
    """Return the names in the code, keyed by name in files with levels in a quantity.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE
    >>> names = PLATE_AMPLITUDE.in_code
    >>> names["standard_um_pp"], names["amplitude_before_um_pp"], names["levels"], names["trial"]
    ('standard_level', 'level_before', 'levels?', 'trial')
    """
    escaped = {name: re.escape(word) for name, word in words._asdict().items()}
    patterns = [(re.compile(file.format(**PLACES, **escaped)), code) for code, file in NAMES]
    names = in_file(words)

    def convert(name: str) -> str:
        for pattern, code in patterns:
            if found := pattern.fullmatch(name):
                return code.format(**found.groupdict())
        return name if names[name] == name else name + UNKNOWN

    return Names(convert)


def is_level(name: str) -> bool:
    """Return whether a name in the code refers to a level.

    >>> is_level("standard_level"), is_level("trial")
    (True, False)
    """
    return any(re.fullmatch(code.format(**PLACES), name) for code, file in NAMES if code != file)


def renamed(data: Any, name: Callable[[str], str]) -> Any:
    """Rename the keys of all dicts in nested dicts and lists."""
    if isinstance(data, dict):
        return {name(key): renamed(value, name) for key, value in data.items()}
    if isinstance(data, list | tuple) and data and not isinstance(data[0], float | int | str):
        return [renamed(each, name) for each in data]
    return data
