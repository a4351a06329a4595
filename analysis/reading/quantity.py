"""What was presented and judged: the plate's amplitude and slipperiness, or the data's own.

Whatever writes a sentence, table, axis or key takes a `Quantity`. A text that is declared rather
than computed has places for it, such as ``"pairs of {q.levels}"``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

#: Levels of a quantity of another make are told apart to so many significant digits.
DIGITS = 9


#: What names of fields and columns say of the quantity.
IN_NAME = re.compile(r"amplitude_um_pp|um_pp|(?<=_)um$|amplitudes?")


@dataclass(frozen=True, slots=True, kw_only=True)
class YesNoWords:
    """What a task of yes and no is called: of a plate, steps down; elsewhere, single stimuli.

    ``trials``, ``down`` (with a change) and ``catch`` (without) are singular and plural; "yes"
    depends on ``size``, is listed for ``each``, and its sensitivity by ``kind``, ``at`` a value.
    """

    size: str
    name: str = "yes and no"
    task: str = "yes and no"
    trials: tuple[str, str] = ("trial", "trials")
    down: tuple[str, str] = ("stimulus", "stimuli")
    catch: tuple[str, str] = ("catch trial", "catch trials")
    each: str = "level"
    kind: str = "level"
    at: str = "at"


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """What the stimuli differed in, and how the report speaks of it.

    Columns keep the name ``amplitude_um_pp`` inside the analysis, whatever the quantity; what is
    written for a reader carries ``column``.

    Parameters
    ----------
    name : str
        A noun: "sound pressure".
    unit : str
        As it is written: "µPa"; may be empty.
    convention : str
        What the unit leaves open: "peak to peak"; may be empty.
    column : str
        Its column in the files that are written.
    judged : str
        What the participants judged: "loudness".
    decimals : int or None
        Levels are told apart to so many decimals; None: to `DIGITS` significant digits.
    stimulus, stimuli : str
        What has the quantity, and the plural.
    """

    name: str
    unit: str = ""
    convention: str = ""
    column: str
    judged: str
    decimals: int | None = None
    stimulus: str = "stimulus"
    stimuli: str = "stimuli"

    @property
    def of_plate(self) -> bool:
        """Whether this is the plate's amplitude: film, friction and the paper speak of it."""
        return self == PLATE_AMPLITUDE

    @property
    def level(self) -> str:
        """One of its values: "amplitude", "level of sound pressure"."""
        return "amplitude" if self.of_plate else f"level of {self.name}"

    @property
    def levels(self) -> str:
        """The plural: "amplitudes", "levels of sound pressure"."""
        return "amplitudes" if self.of_plate else f"levels of {self.name}"

    @property
    def in_full(self) -> str:
        """The name where it is introduced."""
        return "vibration amplitude" if self.of_plate else self.name

    @property
    def perceived(self) -> str:
        """What was judged where it is introduced."""
        return "perceived slipperiness" if self.of_plate else self.judged

    @property
    def yes_no(self) -> YesNoWords:
        """The words of a task of yes and no."""
        return STEPS if self.of_plate else YesNoWords(size=self.name)

    @property
    def title(self) -> str:
        """The name at the head of a column or an axis."""
        return capitalised(self.name)

    @property
    def short_convention(self) -> str:
        """The convention at the head of a column."""
        return SHORT.get(self.convention, "")

    @property
    def short_unit(self) -> str:
        """The unit at the head of a column."""
        return ", ".join(part for part in (self.unit, self.short_convention) if part)

    @property
    def axis(self) -> str:
        """The label of an axis."""
        return capitalised(self.headed(self.in_full))

    def headed(self, text: str) -> str:
        """Return a text with the unit in parentheses behind it."""
        unit = ", ".join(part for part in (self.unit, self.convention) if part)
        return f"{text} ({unit})" if unit else text

    @property
    def per(self) -> str:
        """Behind a slope: "per µm (peak to peak)"."""
        unit = self.unit or f"unit of {self.name}"
        return f"per {unit} ({self.convention})" if self.convention else f"per {unit}"

    def key(self, name: str) -> str:
        """Return how a field or column of ours is named in a file.

        >>> loudness = Quantity(name="pressure", unit="Pa", column="pressure_Pa", judged="loudness")
        >>> loudness.key("from_um_pp"), loudness.key("amplitude"), PLATE_AMPLITUDE.key("amplitude")
        ('from_pressure_Pa', 'stimulus', 'amplitude')
        """
        if self.of_plate:
            return name
        words = {"amplitude": "stimulus", "amplitudes": "levels"}
        return IN_NAME.sub(lambda found: words.get(found[0], self.column), name)

    def columns(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return a table of ours under the names that its columns have in a file."""
        return table.rename(columns=lambda name: self.key(str(name)))

    def with_convention(self, levels: str) -> str:
        """Return levels with their unit and what it leaves open: "0.5, 1.2 µm (peak to peak)"."""
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
    """Return a text with its first letter as a capital."""
    return text[:1].upper() + text[1:]


#: How a heading shortens a convention.
SHORT = {"peak to peak": "p-p"}
#: Amplitudes are told apart to 0.1 nm: 0.1 + 0.2 µm is 0.3 µm.
AMPLITUDE_DECIMALS = 4
PLATE_AMPLITUDE = Quantity(
    name="amplitude",
    unit="µm",
    convention="peak to peak",
    column="amplitude_um_pp",
    judged="slipperiness",
    decimals=AMPLITUDE_DECIMALS,
    stimulus="surface",
    stimuli="surfaces",
)
STEPS = YesNoWords(
    name="descending difference",
    task="the descending difference",
    trials=("step", "steps"),
    down=("step down", "steps down"),
    catch=("catch step", "catch steps"),
    each="step down",
    size="the size of the step",
    kind="step size",
    at="for steps of",
)
