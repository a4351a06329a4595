"""What was presented and judged: the plate's amplitude and slipperiness, or the data's own."""

from __future__ import annotations

from dataclasses import dataclass

#: Levels of a quantity of another make are told apart to so many significant digits.
DIGITS = 9


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
    """

    name: str
    unit: str = ""
    convention: str = ""
    column: str
    judged: str
    decimals: int | None = None

    @property
    def of_plate(self) -> bool:
        """Whether this is the plate's amplitude: film, friction and the paper speak of it."""
        return self == PLATE_AMPLITUDE

    @property
    def levels(self) -> str:
        """The plural: "amplitudes", "levels of sound pressure"."""
        return "amplitudes" if self.of_plate else f"levels of {self.name}"

    @property
    def title(self) -> str:
        """The name at the head of a column or an axis."""
        return self.name[:1].upper() + self.name[1:]

    @property
    def short_unit(self) -> str:
        """The unit at the head of a column."""
        return ", ".join(part for part in (self.unit, SHORT.get(self.convention, "")) if part)

    @property
    def axis(self) -> str:
        """The label of an axis."""
        if self.of_plate:
            return "Vibration amplitude (µm, peak to peak)"
        return f"{self.title} ({self.unit})" if self.unit else self.title

    @property
    def per(self) -> str:
        """Behind a slope: "per µm (peak to peak)"."""
        unit = self.unit or f"unit of {self.name}"
        return f"per {unit} ({self.convention})" if self.convention else f"per {unit}"

    def value(self, level: float | str) -> str:
        """Return a level with its unit.

        >>> PLATE_AMPLITUDE.value(0.5)
        '0.5 µm'
        """
        number = level if isinstance(level, str) else f"{level:g}"
        return f"{number} {self.unit}".strip()


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
)
