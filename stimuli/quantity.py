"""The quantity of the levels: the plate's amplitude in µm peak to peak, V, m/s², or the data's own.

A level is a number in a quantity; names in the code do not contain its unit. The quantity provides
names and words for levels in input and output: files, tables, sentences, axes. Texts that are
declared rather than computed have placeholders for it, such as ``"pairs of {q.levels}"``. For the
names of fields in files, see `slipscale.stimuli.field_names`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from slipscale.stimuli.attributes import SLIPPERINESS, english_adjective
from slipscale.stimuli.field_names import in_um
from slipscale.stimuli.yes_no_words import STEPS, YesNoWords

if TYPE_CHECKING:
    import pandas as pd

#: Significant digits to which levels are distinguished if a quantity defines no decimals.
DIGITS = 9
#: What was judged in a table that does not state it.
UNNAMED = "magnitude"
#: The parts of field and column names that depend on the quantity.
IN_NAME = re.compile(r"amplitude_um_pp|um_pp|(?<=_)um$|amplitudes?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """The quantity in which the stimuli differed, and its words in reports.

    The analysis uses the column name ``amplitude_um_pp`` internally, whatever the quantity; output
    for readers uses ``column``.

    Parameters
    ----------
    name : str
        A noun: "sound pressure".
    unit : str
        As written: "µPa"; may be empty.
    convention : str
        What the unit does not state: "peak to peak"; may be empty.
    column : str
        The column's name in written files.
    judged : str
        What the participants judged: "loudness".
    decimals : int or None
        Decimals to which levels are distinguished; None for `DIGITS` significant digits.
    stimulus, stimuli : str
        The object that has the quantity, singular and plural.
    noun, nouns : str
        Replacement of ``amplitude`` and ``amplitudes`` in names in files.
    suffix : str
        Replacement of ``um_pp`` if the column is noun and suffix; default: the whole column.
    yes : str
        The data's word for "yes": "faster".
    falls : bool
        Whether the judged property falls with the level, as roughness does with a spatial period.
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
        """Name, unit and convention; plates with the same ones produce the same quantity."""
        return self.name, self.unit, self.convention

    @property
    def of_plate(self) -> bool:
        """Whether this is the plate's amplitude, the quantity of film, friction and the paper."""
        return self == PLATE_AMPLITUDE

    @property
    def adjective(self) -> str:
        """The English adjective for the judged property: "slippery"."""
        return english_adjective(self.judged)

    @property
    def in_um_pp(self) -> bool:
        """Whether its levels are the plate's amplitudes in µm, whatever property was judged."""
        return self.makes == PLATE_AMPLITUDE.makes

    @property
    def stepped(self) -> bool:
        """Whether a plate produces it, so that a descending difference has steps in it."""
        return bool(self.suffix)

    @property
    def level(self) -> str:
        """The noun for a single value: "amplitude", "level of sound pressure"."""
        return self.noun.replace("_", " ") if self.suffix else f"level of {self.name}"

    @property
    def levels(self) -> str:
        """The noun for several values: "amplitudes", "levels of sound pressure"."""
        return self.nouns.replace("_", " ") if self.suffix else f"levels of {self.name}"

    @property
    def in_full(self) -> str:
        """The name at its first use."""
        return "vibration amplitude" if self.of_plate else self.name

    @property
    def in_full_title(self) -> str:
        """The name at its first use, at the beginning of a description."""
        return capitalised(self.in_full)

    @property
    def perceived(self) -> str:
        """The judged property at its first use."""
        return "perceived slipperiness" if self.of_plate else self.judged

    @property
    def yes_no(self) -> YesNoWords:
        """The words for a yes/no task."""
        return STEPS if self.stepped else YesNoWords(size=self.name)

    @property
    def more(self) -> str:
        """The answer to a comparison for the stimulus with more: "more slippery".

        In a table with its own word for yes, or without the judged property: that word.
        """
        if self.yes != "yes" or self.judged == UNNAMED:
            return self.yes
        return f"{'less' if self.falls else 'more'} {self.adjective}"

    @property
    def grow(self) -> str:
        """How judgements change as the level grows: "grow", or "fall"."""
        return "fall" if self.falls else "grow"

    @property
    def shrink(self) -> str:
        """How judgements change as the level is reduced: "fall", or "grow"."""
        return "grow" if self.falls else "fall"

    @property
    def title(self) -> str:
        """The name as the heading of a column or an axis."""
        return capitalised(self.name)

    @property
    def short_convention(self) -> str:
        """The convention in a column's heading."""
        return SHORT.get(self.convention, "")

    @property
    def short_unit(self) -> str:
        """The unit in a column's heading."""
        return ", ".join(part for part in (self.unit, self.short_convention) if part)

    @property
    def unit_in_full(self) -> str:
        """The unit with its convention: "µm peak to peak", "V peak"."""
        return " ".join(part for part in (self.unit, self.convention) if part)

    @property
    def unit_in_short(self) -> str:
        """The unit with its convention, for screens and messages: "µm p-p", "V peak"."""
        short = SHORT.get(self.convention, self.convention)
        return " ".join(part for part in (self.unit, short) if part)

    @property
    def behind(self) -> str:
        """The convention at the end of a description: ", peak to peak"."""
        return f", {self.convention}" if self.convention else ""

    @property
    def bids(self) -> str:
        """The unit in BIDS notation: "um", "m/s^2"."""
        return self.unit.translate(BIDS)

    def short(self, level: float) -> str:
        """Return a level with its short unit: "0.5 µm p-p"."""
        return f"{level:g} {self.unit_in_short}".strip()

    @property
    def axis(self) -> str:
        """The label of an axis."""
        return capitalised(self.headed(self.in_full))

    @property
    def change(self) -> str:
        """The label of an axis of differences from a standard."""
        return self.headed("Difference from the standard")

    def heading(self, text: str) -> str:
        """Return the head of a column with the unit alone: "Threshold (µm)"."""
        return f"{text} ({self.unit})" if self.unit else text

    def headed(self, text: str) -> str:
        """Return a text with the unit in parentheses after it."""
        unit = ", ".join(part for part in (self.unit, self.convention) if part)
        return f"{text} ({unit})" if unit else text

    @property
    def per(self) -> str:
        """The unit after a slope: "per µm (peak to peak)"."""
        unit = self.unit or f"unit of {self.name}"
        return f"per {unit} ({self.convention})" if self.convention else f"per {unit}"

    def key(self, name: str) -> str:
        """Return the name in a file of one of our fields or columns.

        >>> loudness = Quantity(name="pressure", unit="Pa", column="pressure_Pa", judged="loudness")
        >>> loudness.key("from_um_pp"), loudness.key("amplitude"), PLATE_AMPLITUDE.key("amplitude")
        ('from_pressure_Pa', 'stimulus', 'amplitude')
        """
        if self.of_plate:
            return name
        words = {
            "amplitude": self.noun,
            "amplitudes": self.nouns,
            "amplitude_um_pp": self.column,
        }
        return IN_NAME.sub(lambda found: words.get(found[0], self.suffix or self.column), name)

    def in_um(self, column: str) -> str:
        """Return the name in files in µm for a column of a file in this quantity.

        >>> voltage = made_by_plate("voltage", "V", "peak")
        >>> [voltage.in_um(name) for name in ("voltage_v_peak", "standard_v_peak", "trial")]
        ['amplitude_um_pp', 'standard_um_pp', 'trial']
        """
        stem = column.removesuffix(f"_{self.suffix}")
        if not self.suffix or stem == column:
            return column
        return re.sub(rf"^(interval\d+_)?{self.noun}(?=_|$)", r"\1amplitude", stem) + "_um_pp"

    def named(self, name: str) -> str:
        """Return the name in a file in this quantity for a name in the code.

        >>> PLATE_AMPLITUDE.named("standard_level")
        'standard_um_pp'
        """
        return self.key(in_um(name))

    def columns(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return one of our tables with the column names of a file."""
        return table.rename(columns=lambda name: self.key(str(name)))

    def with_convention(self, levels: str) -> str:
        """Return levels with their unit and convention: "0.5, 1.2 µm (peak to peak)"."""
        behind = f" ({self.convention})" if self.convention else ""
        return f"{self.value(levels)}{behind}"

    def value(self, level: float | str) -> str:
        """Return a level with its unit.

        >>> PLATE_AMPLITUDE.value(0.5)
        '0.5 µm'
        """
        number = level if isinstance(level, str) else f"{level:g}"
        return f"{number} {self.unit}".strip()


def capitalised(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]


#: Replacements of non-ASCII characters in BIDS units.
BIDS = str.maketrans({"µ": "u", "²": "^2", "³": "^3", "°": "deg", "Ω": "Ohm"})
#: Short forms of conventions in headings.
SHORT = {"peak to peak": "p-p"}
#: Conventions in names in files.
IN_KEYS = {"peak to peak": "pp", "peak": "peak", "RMS": "rms", "": ""}
#: Amplitudes are distinguished to 0.1 nm: 0.1 + 0.2 µm is 0.3 µm.
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
    """Return a quantity that a plate produces, for a study's levels.

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
        nouns=re.sub(r"(?<=[^aeiou])y$", "ie", noun) + "s",
        suffix=suffix,
        falls=falls,
    )
