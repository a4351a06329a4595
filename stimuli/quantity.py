"""Define the quantity in which levels are given, such as amplitude in µm peak to peak, V or m/s².

A level is a value of this quantity. `Quantity` provides its name and unit for files, tables,
sentences and axis labels. Fixed text contains placeholders, such as ``"pairs of {q.levels}"``. For
the names of fields in files, see `slipscale.stimuli.level_names`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipscale.faults.message import Message
from slipscale.stimuli.attributes import SLIPPERINESS, english_adjective
from slipscale.stimuli.level_names import Names, Words, in_code, in_file
from slipscale.stimuli.yes_no_words import STEPS, YesNoWords

if TYPE_CHECKING:
    import pandas as pd

#: Significant digits of levels if a quantity does not define decimals.
DIGITS = 9
#: Default word for the judged property.
UNNAMED = "magnitude"


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """Physical quantity that varies between stimuli, and the words used for it in reports.

    In the code, the column of levels is always called ``level``. In files, this column has the name
    ``column``.

    Parameters
    ----------
    name : str
        Name as a noun, such as "sound pressure".
    unit : str
        Unit, such as "µPa"; may be empty.
    convention : str
        Convention that qualifies the unit, such as "peak to peak"; may be empty.
    column : str
        Name of the column in files.
    judged : str
        Judged property, such as "loudness".
    decimals : int or None
        Number of decimals of a level; if None, levels have `DIGITS` significant digits.
    stimulus, stimuli : str
        Noun for a stimulus with this quantity, in the singular and the plural.
    noun, nouns : str
        Nouns for one and several levels in column names and keys of files.
    suffix : str
        Unit at the end of column names and keys of files (default: ``column``).
    yes : str
        Answer that corresponds to "yes" in the data, such as "faster".
    falls : bool
        Whether the judged property decreases with the level.
    """

    name: str
    unit: str = ""
    convention: str = ""
    column: str
    judged: str
    decimals: int | None = None
    stimulus: str = "stimulus"
    stimuli: str = "stimuli"
    noun: str = "stimulus"
    nouns: str = "levels"
    suffix: str = ""
    yes: str = "yes"
    falls: bool = False

    @property
    def makes(self) -> tuple[str, str, str]:
        """Name, unit and convention, which identify the quantity that a plate produces."""
        return self.name, self.unit, self.convention

    @property
    def of_plate(self) -> bool:
        """Whether this is the default quantity: amplitude in µm, judged for slipperiness."""
        return self == PLATE_AMPLITUDE

    @property
    def adjective(self) -> str:
        """English adjective for the judged property, such as "slippery"."""
        return english_adjective(self.judged)

    @property
    def in_um_pp(self) -> bool:
        """Whether levels are plate amplitudes in µm, regardless of the judged property."""
        return self.makes == PLATE_AMPLITUDE.makes

    @property
    def stepped(self) -> bool:
        """Whether a plate produces the quantity, so that the trials of a yes/no task are steps."""
        return bool(self.suffix)

    @property
    def level(self) -> str:
        """Noun for a single value, such as "amplitude" or "level of sound pressure"."""
        return self.noun.replace("_", " ") if self.suffix else f"level of {self.name}"

    @property
    def levels(self) -> str:
        """Noun for several values, such as "amplitudes" or "levels of sound pressure"."""
        return self.nouns.replace("_", " ") if self.suffix else f"levels of {self.name}"

    @property
    def in_full(self) -> str:
        """Full name of the quantity, to be used at its first mention."""
        return "vibration amplitude" if self.of_plate else self.name

    @property
    def in_full_title(self) -> str:
        """Full name of the quantity, capitalised for the beginning of a description."""
        return capitalised(self.in_full)

    @property
    def perceived(self) -> str:
        """Full name of the judged property, to be used at its first mention."""
        return "perceived slipperiness" if self.of_plate else self.judged

    @property
    def yes_no(self) -> YesNoWords:
        """Wording of reports on a yes/no task."""
        return STEPS if self.stepped else YesNoWords(size=self.name)

    @property
    def more(self) -> str:
        """Answer that selects the stimulus with the higher level, such as "more slippery".

        The answer is the attribute ``yes`` if this is a word other than "yes", or if the judged
        property has no name.
        """
        if self.yes != "yes" or self.judged == UNNAMED:
            return self.yes
        return f"{'less' if self.falls else 'more'} {self.adjective}"

    @property
    def grow(self) -> str:
        """Verb for judgements when the level increases: "grow" or "fall"."""
        return "fall" if self.falls else "grow"

    @property
    def shrink(self) -> str:
        """Verb for judgements when the level decreases: "fall" or "grow"."""
        return "grow" if self.falls else "fall"

    @property
    def title(self) -> str:
        """Capitalised name, for a column heading or an axis label."""
        return capitalised(self.name)

    @property
    def short_convention(self) -> str:
        """Abbreviation of the convention for a column heading, such as "p-p"."""
        return SHORT.get(self.convention, "")

    @property
    def short_unit(self) -> str:
        """Unit and abbreviation of the convention, for a column heading."""
        return ", ".join(part for part in (self.unit, self.short_convention) if part)

    @property
    def unit_in_full(self) -> str:
        """Unit with convention, such as "µm peak to peak" or "V peak"."""
        return " ".join(part for part in (self.unit, self.convention) if part)

    @property
    def unit_in_short(self) -> str:
        """Unit with the short form of the convention, such as "µm p-p"."""
        short = SHORT.get(self.convention, self.convention)
        return " ".join(part for part in (self.unit, short) if part)

    @property
    def behind(self) -> str:
        """Convention, formatted as the end of a description, such as ", peak to peak"."""
        return f", {self.convention}" if self.convention else ""

    @property
    def bids(self) -> str:
        """Unit in BIDS notation, such as "um" or "m/s^2"."""
        return self.unit.translate(BIDS)

    def short(self, level: float) -> str:
        """Format a level with an abbreviated unit, such as "0.5 µm p-p"."""
        if not (unit := self.unit_in_short):
            return f"{level:g}"
        return Message("{level} {unit}", level=f"{level:g}", unit=unit)

    @property
    def axis(self) -> str:
        """Label of an axis."""
        return capitalised(self.headed(self.in_full))

    @property
    def change(self) -> str:
        """Label of an axis that shows differences from the standard."""
        return self.headed("Difference from the standard")

    def heading(self, text: str) -> str:
        """Return a column heading with the unit, such as "Threshold (µm)"."""
        return f"{text} ({self.unit})" if self.unit else text

    def headed(self, text: str) -> str:
        """Append the unit in parentheses to a text."""
        unit = ", ".join(part for part in (self.unit, self.convention) if part)
        return f"{text} ({unit})" if unit else text

    @property
    def per(self) -> str:
        """Unit of a slope with respect to the level, such as "per µm (peak to peak)"."""
        unit = self.unit or f"unit of {self.name}"
        return f"per {unit} ({self.convention})" if self.convention else f"per {unit}"

    @property
    def _words(self) -> Words:
        unit = self.suffix or self.column
        tolerance = "um" if self.in_um_pp else unit
        return Words(self.column, self.noun, self.nouns, unit, tolerance)

    @property
    def in_file(self) -> Names:
        """Names in files, keyed by name in the code."""
        return in_file(self._words)

    @property
    def in_code(self) -> Names:
        """Names in the code, keyed by name in files; names of the code are unknown in files."""
        return in_code(self._words)

    def named(self, name: str) -> str:
        """Convert a name in the code to the name in files whose levels are in this quantity.

        >>> PLATE_AMPLITUDE.named("standard_level")
        'standard_um_pp'
        """
        return self.in_file[name]

    def columns(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the table with its columns renamed for a file in this quantity."""
        names = self.in_file
        return table.rename(columns=lambda name: names[str(name)])

    def with_convention(self, levels: str) -> str:
        """Append the unit and convention to levels, as in "0.5, 1.2 µm (peak to peak)"."""
        behind = f" ({self.convention})" if self.convention else ""
        return f"{self.value(levels)}{behind}"

    def value(self, level: float | str) -> str:
        """Format a level with its unit.

        >>> PLATE_AMPLITUDE.value(0.5), made_by_plate("duty cycle", "share", "").value(0.5)
        ('0.5 µm', '0.5')
        """
        number = level if isinstance(level, str) else f"{level:g}"
        return number if self.unit == "share" else f"{number} {self.unit}".strip()


def capitalised(text: str) -> str:
    """Capitalise the first letter of a text."""
    return text[:1].upper() + text[1:]


#: Replacements of non-ASCII characters in BIDS units.
BIDS = str.maketrans({"µ": "u", "²": "^2", "³": "^3", "°": "deg", "Ω": "Ohm"})
#: Short forms of conventions in headings.
SHORT = {"peak to peak": "p-p"}
#: Short forms of conventions in column names and keys of files.
IN_KEYS = {"peak to peak": "pp", "peak": "peak", "RMS": "rms", "": ""}
#: Amplitudes are rounded to 0.1 nm, so that 0.1 + 0.2 µm is 0.3 µm.
AMPLITUDE_DECIMALS = 4
PLATE_AMPLITUDE = Quantity(
    name="amplitude",
    unit="µm",
    convention="peak to peak",
    column="amplitude_um_pp",
    judged=SLIPPERINESS,
    decimals=AMPLITUDE_DECIMALS,
    stimulus="surface",
    stimuli="surfaces",
    noun="amplitude",
    nouns="amplitudes",
    suffix="um_pp",
)


def made_by_plate(
    name: str,
    unit: str,
    convention: str,
    judged: str = PLATE_AMPLITUDE.judged,
    *,
    falls: bool = False,
) -> Quantity:
    """Return the quantity for levels that a plate produces.

    >>> made_by_plate("acceleration", "m/s²", "RMS").named("standard_level")
    'standard_m_s2_rms'
    """
    usual = (*PLATE_AMPLITUDE.makes, PLATE_AMPLITUDE.judged, PLATE_AMPLITUDE.falls)
    if (name, unit, convention, judged, falls) == usual:
        return PLATE_AMPLITUDE
    ascii_unit = re.sub(r"\W+", "_", unit.translate(BIDS).replace("^", "")).strip("_").lower()
    suffix = "_".join(part for part in (ascii_unit, IN_KEYS[convention]) if part)
    noun = name.replace(" ", "_")
    return replace(
        PLATE_AMPLITUDE,
        name=name,
        unit=unit,
        convention=convention,
        column=f"{noun}_{suffix}",
        judged=judged,
        decimals=AMPLITUDE_DECIMALS if unit == PLATE_AMPLITUDE.unit else None,
        noun=noun,
        nouns=re.sub(r"(?<=[^aeiou])y$", "ie", re.sub(r"(?<=s)$", "e", noun)) + "s",
        suffix=suffix,
        falls=falls,
    )
