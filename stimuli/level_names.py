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
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from slipscale.stimuli.quantity import Quantity

#: Suffix added to names used in the code that are found in a file, so that they are unknown.
UNKNOWN = "?"
#: Names in the code and in files. The first match applies. For placeholders, see `PLACES`.
NAMES = (
    ("drive_voltage_v_peak", "drive_voltage_v_peak"),  # never a level, even in a study in V peak
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


class Names(dict[str, str]):
    """Names that have been converted once; any other name is converted when it is looked up."""

    def __init__(self, convert: Callable[[str], str]) -> None:
        super().__init__()
        self._convert = convert

    def __missing__(self, name: str) -> str:
        found = self[name] = self._convert(name)
        return found


@cache
def in_file(quantity: Quantity) -> Names:
    """Return the names in files with levels in a quantity, keyed by name in the code.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE, made_by_plate
    >>> names = in_file(PLATE_AMPLITUDE)
    >>> names["levels"], names["interval2_level"], names["highest_level"], names["trial"]
    ('amplitudes_um_pp', 'interval2_amplitude_um_pp', 'highest_um_pp', 'trial')
    >>> in_file(made_by_plate("acceleration", "m/s²", "RMS"))["standard_level"]
    'standard_m_s2_rms'
    """
    words = _words(quantity)

    def convert(name: str) -> str:
        if name in RESULTS:
            return words[RESULTS[name]]
        for code, file in NAMES:
            if found := re.fullmatch(code.format(**PLACES), name):
                return file.format(**words, **found.groupdict())
        return name

    return Names(convert)


def path_in_file(path: str, quantity: Quantity) -> str:
    """Convert the names in the path to a result; ``levels`` in a path are levels of a factor.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE
    >>> path_in_file("matching.bias_level.mean", PLATE_AMPLITUDE)
    'matching.bias_um_pp.mean'
    """
    names = in_file(quantity)
    return ".".join(part if part == "levels" else names[part] for part in path.split("."))


@cache
def in_code(quantity: Quantity) -> Names:
    """Return the names in the code, keyed by name in files with levels in a quantity.

    >>> from slipscale.stimuli.quantity import PLATE_AMPLITUDE
    >>> names = in_code(PLATE_AMPLITUDE)
    >>> names["standard_um_pp"], names["amplitude_before_um_pp"], names["levels"], names["trial"]
    ('standard_level', 'level_before', 'levels?', 'trial')
    """
    escaped = {name: re.escape(word) for name, word in _words(quantity).items()}
    patterns = [(re.compile(file.format(**PLACES, **escaped)), code) for code, file in NAMES]
    names = in_file(quantity)

    def convert(name: str) -> str:
        for pattern, code in patterns:
            if found := pattern.fullmatch(name):
                return code.format(**found.groupdict())
        return name if names[name] == name else name + UNKNOWN

    return Names(convert)


def _words(quantity: Quantity) -> dict[str, str]:
    """Return the parts of names that depend on the quantity."""
    unit = quantity.suffix or quantity.column
    return {
        "column": quantity.column,
        "noun": quantity.noun,
        "nouns": quantity.nouns,
        "unit": unit,
        "tolerance": "um" if quantity.of_plate else unit,
    }


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


@dataclass(frozen=True, slots=True)
class FileNames:
    """Converter between field names and the keys used in files with levels in ``quantity``.

    Parameters
    ----------
    quantity : Quantity
    fields : frozenset of str
        Fields that contain levels.
    tables : frozenset of str
        Tables whose keys are converted, in addition to the keys at the top level.
    other : Mapping
        Quantities of tables whose levels are not in the study's quantity, keyed by table.
    """

    quantity: Quantity
    fields: frozenset[str]
    tables: frozenset[str]
    other: Mapping[str, Quantity] = field(default_factory=dict)

    def in_file(self, place: tuple[int | str, ...]) -> tuple[int | str, ...]:
        """Replace the field names in the position of an error with the keys used in the file."""
        top = place[0] if place else ""
        keys = len(place) if top in self.tables else 1
        quantity = self.quantity_in(top)
        return (
            *(
                self._key(part, quantity) if isinstance(part, str) else part
                for part in place[:keys]
            ),
            *place[keys:],
        )

    def to_code(self, table: dict[str, Any]) -> dict[str, Any]:
        """Replace the keys of a file with the field names of the model."""

        def naming(quantity: Quantity) -> Callable[[str], str]:
            # In files, names with a unit are valid keys, and field names are not.
            field_of = {field: field + UNKNOWN for field in self.fields}
            field_of |= {self._key(field, quantity): field for field in self.fields}
            return lambda key: field_of.get(key, key)

        return self._converted(table, naming)

    def to_file(self, table: dict[str, object]) -> dict[str, object]:
        """Replace field names with the keys used in the file."""
        return self._converted(table, lambda quantity: lambda key: self._key(key, quantity))

    def _converted(
        self, table: dict[str, object], naming: Callable[[Quantity], Callable[[str], str]]
    ) -> dict[str, object]:
        name = naming(self.quantity)
        return {
            name(key): renamed(value, naming(self.quantity_in(key)))
            if key in self.tables
            else value
            for key, value in table.items()
        }

    def quantity_in(self, table: int | str) -> Quantity:
        """Return the quantity used for levels in a table or in a top-level key."""
        return self.other.get(str(table), self.quantity)

    def _key(self, field: str, quantity: Quantity) -> str:
        return in_file(quantity)[field] if field in self.fields else field.removesuffix(UNKNOWN)
