"""A published table as data: scale and columns, read from TOML or CSV, validated whole."""

from __future__ import annotations

import csv
import tomllib
from dataclasses import dataclass, fields
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.reconstruction.rounding import RULES, Printed
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping

CONVENTIONS = ("sample", "population")
SHIPPED = Path(__file__).parent.parent / "published"


@dataclass(frozen=True, kw_only=True)
class Scale:
    """The values that a rating can take: from `minimum` to `maximum` in steps of `step`.

    Raises
    ------
    UserError
        The step does not divide the scale, or the scale is empty.
    """

    minimum: Fraction = Fraction(0)
    maximum: Fraction
    step: Fraction = Fraction(1)

    def __post_init__(self) -> None:
        if self.step <= 0:
            raise UserError(f"scale: step is {self.step}, expected a number above 0")
        if self.maximum <= self.minimum:
            raise UserError(f"scale: maximum {self.maximum} is not above minimum {self.minimum}")
        if (self.maximum - self.minimum) % self.step:
            raise UserError(
                f"scale: step {self.step} does not divide the scale from {self.minimum} to "
                f"{self.maximum}; expected a whole number of steps"
            )

    @property
    def steps(self) -> int:
        """Number of steps from the minimum to the maximum."""
        return int((self.maximum - self.minimum) / self.step)

    def value(self, steps: int) -> Fraction:
        """Return the rating that lies `steps` above the minimum."""
        return self.minimum + steps * self.step


@dataclass(frozen=True, kw_only=True)
class Column:
    """One column of a published table, numbers as printed.

    Parameters
    ----------
    label : str
        Its heading.
    n : int
        Number of ratings, 2 or more.
    mean, sd : Printed
        Mean and standard deviation; decimals count.
    scale : Scale
        What a rating can be.
    sd_convention : {"sample", "population"}
        Whether the standard deviation divides by n - 1 or by n.
    rounding : {"nearest", "half_up", "half_even", "truncated"}
        How every number of the column was rounded.
    maximum_deviation : Printed, optional
        The largest distance of a rating from the (unrounded) mean.
    observed_minimum, observed_maximum : Printed, optional
        The smallest and the largest rating; both are present.
    median : Printed, optional
        The middle rating, or the mean of the two middle ones.
    amplitude_um_pp : float, optional
        Of the vibration, µm peak to peak; for the exponents.

    Raises
    ------
    UserError
        An entry is impossible or contradicts another.
    """

    label: str
    n: int
    mean: Printed
    sd: Printed
    scale: Scale
    sd_convention: str = "sample"
    rounding: str = "nearest"
    maximum_deviation: Printed | None = None
    observed_minimum: Printed | None = None
    observed_maximum: Printed | None = None
    median: Printed | None = None
    amplitude_um_pp: float | None = None

    def __post_init__(self) -> None:
        if self.n < 2:  # noqa: PLR2004 - a standard deviation needs two
            raise self._fault(f"n is {self.n}, expected 2 or more")
        if self.sd_convention not in CONVENTIONS:
            raise self._fault(
                f"sd_convention is '{self.sd_convention}', expected {' or '.join(CONVENTIONS)}"
            )
        if self.rounding not in RULES:
            raise self._fault(f"rounding is '{self.rounding}', expected one of {', '.join(RULES)}")
        if self.amplitude_um_pp is not None and not 0 <= self.amplitude_um_pp < inf:
            raise self._fault(f"amplitude_um_pp is {self.amplitude_um_pp}, expected 0 or more")
        low, high = self.scale.minimum, self.scale.maximum
        for name in ("mean", "median", "observed_minimum", "observed_maximum"):
            printed = getattr(self, name)
            if printed and not low - printed.unit < printed.value < high + printed.unit:
                raise self._fault(f"{name} {printed.text} lies outside the scale, {low} to {high}")
        for name in ("sd", "maximum_deviation"):
            printed = getattr(self, name)
            if printed and not 0 <= printed.value <= high - low:
                raise self._fault(
                    f"{name} {printed.text} is impossible on a scale from {low} to {high}"
                )
        self._check_order()

    def _check_order(self) -> None:
        """Refuse a mean or a median outside the observed extremes."""
        for smaller, larger in (
            ("observed_minimum", "observed_maximum"),
            ("observed_minimum", "median"),
            ("median", "observed_maximum"),
            ("observed_minimum", "mean"),
            ("mean", "observed_maximum"),
        ):
            a, b = getattr(self, smaller), getattr(self, larger)
            if a and b and a.value - a.unit >= b.value + b.unit:
                raise self._fault(f"{smaller} {a.text} and {larger} {b.text} contradict each other")

    def _fault(self, what: str) -> UserError:
        return UserError(f"column '{self.label}': {what}")


@dataclass(frozen=True)
class PublishedTable:
    """A title and the columns under it."""

    title: str
    columns: tuple[Column, ...]


# The keys of a column that hold a printed number, a word or a whole number.
PRINTED = ("mean", "sd", "maximum_deviation", "observed_minimum", "observed_maximum", "median")
WORDS = ("label", "sd_convention", "rounding")
SCALE = tuple(field.name for field in fields(Scale))
AMPLITUDE = "amplitude_um_pp"
NEEDED = ("n", "mean", "sd")


def read(path: Path) -> PublishedTable:
    """Read a table from a TOML or CSV file, or the name of a shipped one.

    Raises
    ------
    UserError
        No such table, it cannot be read, or an entry is wrong.
    """
    shipped = SHIPPED / f"{path}.toml"
    if not path.exists() and path.name == str(path) and shipped.exists():
        path = shipped
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        names = ", ".join(sorted(p.stem for p in SHIPPED.glob("*.toml")))
        raise UserError(
            f"{path}: cannot be read ({error}); expected a TOML or CSV file, or one of: {names}"
        ) from None
    try:
        return from_csv(text, path.stem) if path.suffix.lower() == ".csv" else from_toml(text)
    except UserError as error:
        raise UserError(f"{path}: {error}") from None


def from_toml(text: str) -> PublishedTable:
    """Read a table from TOML text: ``[scale]`` and one ``[[column]]`` each."""
    try:
        # A bare number keeps its printed decimals: 12.50 stays "12.50".
        content = tomllib.loads(text, parse_float=str)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"not TOML: {error}") from None
    unknown = set(content) - {"title", "scale", "column"}
    if unknown:
        raise UserError(f"unknown key '{min(unknown)}'; expected title, scale or column")
    scale, columns = content.get("scale"), content.get("column")
    if not isinstance(scale, dict):
        raise UserError("no [scale]; expected its minimum, maximum and step")
    if not isinstance(columns, list) or not columns:
        raise UserError("no [[column]]; expected at least one with n, mean and sd")
    common = _scale(scale)
    return PublishedTable(
        str(content.get("title", "")),
        tuple(_column(entry, common, place) for place, entry in enumerate(columns, 1)),
    )


def from_csv(text: str, title: str = "") -> PublishedTable:
    """Read a table from CSV text: one row a column of the published table.

    The header names ``label``, ``n``, ``mean``, ``sd``, ``scale_minimum``, ``scale_maximum``
    and what else a TOML column has; empty cells are absent.
    """
    rows = list(csv.DictReader(text.splitlines()))
    if not rows:
        raise UserError("no rows; expected a header and one row a column")
    columns = []
    for place, row in enumerate(rows, 1):
        if None in row or None in row.values():
            raise UserError(f"row {place}: expected as many cells as the header has")
        entry = {key.strip(): cell.strip() for key, cell in row.items() if cell.strip()}
        scale = {name: entry.pop(f"scale_{name}") for name in SCALE if f"scale_{name}" in entry}
        columns.append(_column(entry, _scale(scale), place))
    return PublishedTable(title, tuple(columns))


def _scale(entry: Mapping[str, Any]) -> Scale:
    unknown = set(entry) - set(SCALE)
    if unknown:
        raise UserError(f"scale: unknown key '{min(unknown)}'; expected {', '.join(SCALE)}")
    if "maximum" not in entry:
        raise UserError("scale: maximum is missing; expected the largest possible rating")
    numbers = {}
    for name, value in entry.items():
        try:
            numbers[name] = Fraction(str(value))
        except (ValueError, ZeroDivisionError):
            raise UserError(
                f"scale: {name} is '{value}', expected a number such as 1, 0.5 or 1/3"
            ) from None
    return Scale(**numbers)


def _column(entry: Mapping[str, Any], scale: Scale, place: int) -> Column:
    label = str(entry.get("label", f"column {place}"))
    known = ("n", AMPLITUDE, *PRINTED, *WORDS)
    unknown = set(entry) - set(known)
    if unknown:
        raise UserError(
            f"column '{label}': unknown key '{min(unknown)}'; expected {', '.join(known)}"
        )
    for name in NEEDED:
        if name not in entry:
            raise UserError(f"column '{label}': {name} is missing")
    values: dict[str, Any] = {name: str(entry[name]) for name in WORDS if name in entry}
    for name in PRINTED:
        if name in entry:
            try:
                values[name] = Printed(str(entry[name]).strip())
            except ValueError as error:
                raise UserError(f"column '{label}': {name}: {error}") from None
    try:
        n = int(str(entry["n"]))
    except ValueError:
        raise UserError(f"column '{label}': n is '{entry['n']}', expected a whole number") from None
    if AMPLITUDE in entry:
        try:
            values[AMPLITUDE] = float(entry[AMPLITUDE])
        except ValueError:
            raise UserError(
                f"column '{label}': {AMPLITUDE} is '{entry[AMPLITUDE]}', expected a number"
            ) from None
    return Column(**{**values, "label": label, "n": n, "scale": scale})
