"""A published table as data: scale and columns, read from TOML or CSV, validated whole.

What is refused here is what cannot be understood. A number that no ratings can have, such as a
mean outside the scale, is a finding and not a mistake of the user: `constraints.targets` answers
it.
"""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    InstanceOf,
    ValidationError,
    field_validator,
    model_validator,
)

from analysis.reconstruction.rounding import Printed, plain_decimal
from faults import UserError
from faults.toml_file import parse_toml
from faults.validation import complaint, faults_in, sentences

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from faults.toml_lines import Place
    from faults.validation import Fault

Convention = Literal["sample", "population"]
CONVENTIONS: tuple[Convention, ...] = get_args(Convention)
# Columns of the same participants, or of other ones each.
Design = Literal["paired", "independent"]
DESIGNS: tuple[Design, ...] = get_args(Design)
SHIPPED = Path(__file__).parent.parent / "published"
# Names of a CSV header that begin so are keys of the scale.
SCALE = "scale_"


def _printed(value: object) -> Printed:
    return value if isinstance(value, Printed) else Printed(_text(value))


def _exact(value: object) -> Fraction:
    """Return a number such as 1, 0.5 or 1/3 as a fraction."""
    if isinstance(value, Fraction):
        return value
    try:
        top, _, bottom = _text(value).partition("/")
        return Fraction(plain_decimal(top)) / Fraction(plain_decimal(bottom or "1"))
    except (ValueError, ZeroDivisionError):
        raise ValueError("expected a number such as 1, 0.5 or 1/3") from None


def _text(value: object) -> str:
    """Return what stands for a number as text; no number is made of lists, tables and dates."""
    return str(value) if isinstance(value, str | int) else ""


Exact = Annotated[InstanceOf[Fraction], BeforeValidator(_exact)]
AsPrinted = Annotated[InstanceOf[Printed], BeforeValidator(_printed)]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Scale(_Record):
    """The values that a rating can take: from `minimum` to `maximum` in steps of `step`.

    With ``items`` a rating is the mean of so many answers; ``step`` is told of an answer, and held
    as a rating's.

    Raises
    ------
    ValueError
        The step does not divide the scale, or the scale is empty.
    """

    minimum: Exact = Fraction(0)
    maximum: Exact
    step: Exact = Fraction(1)

    items: Annotated[int, Field(ge=1, le=1000)] = 1

    @model_validator(mode="before")
    @classmethod
    def _mean_of_items(cls, given: object) -> object:
        """Divide the step of an answer by the number of items: a rating is their mean."""
        items = given.get("items") if isinstance(given, dict) else None
        # Anything else than a number above 0 is refused as the field that it is.
        if not isinstance(given, dict) or not str(items).isdecimal() or not int(str(items)):
            return given
        return given | {"step": _exact(given.get("step", 1)) / int(str(items))}

    @model_validator(mode="after")
    def _whole_steps(self) -> Scale:
        if self.step <= 0:
            raise ValueError(f"step is {self.step}, expected a number above 0")
        if self.maximum <= self.minimum:
            raise ValueError(f"maximum {self.maximum} is not above minimum {self.minimum}")
        if (self.maximum - self.minimum) % self.step:
            raise ValueError(
                f"step {self.step} does not divide the scale from {self.minimum} to "
                f"{self.maximum}; expected a whole number of steps"
            )
        return self

    @property
    def steps(self) -> int:
        """Number of steps from the minimum to the maximum."""
        return int((self.maximum - self.minimum) / self.step)

    def value(self, steps: int) -> Fraction:
        """Return the rating that lies `steps` above the minimum."""
        return self.minimum + steps * self.step


class Summary(_Record):
    """The numbers of one column, as printed; the scale apart.

    Parameters
    ----------
    label : str
        Its heading.
    n : int
        Number of ratings, 2 or more.
    mean, sd : Printed
        Mean and standard deviation; decimals count.
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
    """

    label: str = ""
    n: Annotated[int, Field(ge=2, le=1_000_000)]
    mean: AsPrinted
    sd: AsPrinted
    sd_convention: Convention = "sample"
    rounding: Literal["nearest", "half_up", "half_even", "truncated"] = "nearest"
    maximum_deviation: AsPrinted | None = None
    observed_minimum: AsPrinted | None = None
    observed_maximum: AsPrinted | None = None
    median: AsPrinted | None = None
    amplitude_um_pp: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None

    @field_validator("sd", "maximum_deviation")
    @classmethod
    def _not_negative(cls, printed: Printed | None) -> Printed | None:
        if printed and printed.value < 0:
            raise ValueError("expected 0 or more")
        return printed


class Column(Summary):
    """One column of a published table: its numbers, and ``scale``, what a rating can be."""

    scale: Scale


@dataclass(frozen=True)
class PublishedTable:
    """A title, the columns under it, and whether they are of the same participants."""

    title: str
    columns: tuple[Column, ...]
    design: Design | None = None


@dataclass(frozen=True)
class Row:
    """A row of a CSV file: its cells, and a column or what is wrong with it.

    Parameters
    ----------
    line : int
        On which it ends.
    cells : tuple of str
        As they stand there.
    column : Column or None
        What it says; None if it cannot be understood.
    told : tuple of (int, str)
        Why not: line and words.
    """

    line: int
    cells: tuple[str, ...]
    column: Column | None
    told: tuple[tuple[int, str], ...] = ()


class _File(_Record):
    """A table as its TOML file has it."""

    title: str = ""
    design: Design | None = None
    scale: Scale
    column: Annotated[tuple[Summary, ...], Field(min_length=1)]


def read(path: Path) -> PublishedTable:
    """Read a table from a TOML or CSV file, or the name of a shipped one.

    Raises
    ------
    UserError
        No such table, it cannot be read, or entries are wrong: every fault, each with its line.
    """
    shipped = SHIPPED / f"{path}.toml"
    if not path.exists() and path.name == str(path) and shipped.exists():
        path = shipped
    text = _text_of(path)
    if path.suffix.lower() == ".csv":
        return from_csv(text, str(path), title=path.stem)
    return from_toml(text, str(path))


def read_rows(path: Path) -> list[Row]:
    """Read the rows of a CSV file, those that cannot be understood with the reason.

    Raises
    ------
    UserError
        It cannot be read, is no CSV, or its header is wrong.
    """
    if path.suffix.lower() != ".csv":
        raise UserError(f"{path}: expected a CSV file, a row for each column of a published table")
    return _csv_rows(_text_of(path), str(path))


def _text_of(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        names = ", ".join(sorted(p.stem for p in SHIPPED.glob("*.toml")))
        raise UserError(
            f"{path}: cannot be read ({error}); expected a TOML or CSV file, or one of: {names}"
        ) from None


def from_toml(text: str, source: str = "the table") -> PublishedTable:
    """Read a table from TOML text: ``[scale]`` and one ``[[column]]`` each."""
    # A bare number keeps its printed decimals: 12.50 stays "12.50".
    file = parse_toml(text, source, _File, parse_float=str)
    return PublishedTable(
        file.title,
        tuple(_column(entry, file.scale, place) for place, entry in enumerate(file.column, 1)),
        file.design,
    )


def _column(entry: Summary, scale: Scale, place: int) -> Column:
    given = {name: getattr(entry, name) for name in entry.model_fields_set}
    return Column(**{"label": f"column {place}", **given, "scale": scale})


def from_csv(text: str, source: str = "the table", title: str = "") -> PublishedTable:
    """Read a table from CSV text: one row a column of the published table.

    The header names ``label``, ``n``, ``mean``, ``sd``, ``scale_minimum``, ``scale_maximum``
    and what else a TOML column has; empty cells are absent. Cells are parted by commas, or by
    semicolons or tabs where the header has these.
    """
    rows = _csv_rows(text, source)
    if told := [fault for row in rows for fault in row.told]:
        raise complaint(source, told)
    return PublishedTable(title, tuple(row.column for row in rows if row.column is not None))


def _csv_rows(text: str, source: str) -> list[Row]:
    """Return the rows under the header.

    Raises
    ------
    UserError
        The text is no CSV, has no rows, or the header is wrong.
    """
    try:
        rows = list(_rows(text))
    except csv.Error as error:
        raise UserError(f"{source} is not CSV: {error}") from None
    if len(rows) < 2:  # noqa: PLR2004 - the header and a row
        raise UserError(f"{source} has no rows; expected a header and one row a column")
    (first, header), *rows = rows
    names = [name.strip() for name in header]
    found = [_row(names, line, cells, place) for place, (line, cells) in enumerate(rows, 1)]
    if told := [(first, f"line {first}, {words}") for words in _wrong_names(names)]:
        raise complaint(source, told + [fault for row in found for fault in row.told])
    return found


def _row(names: list[str], line: int, cells: list[str], place: int) -> Row:
    kept = tuple(cells)
    if len(cells) != len(names):
        counts = f"expected {len(names)} cells, as the header has, found {len(cells)}"
        return Row(line, kept, None, ((line, f"line {line}: {counts}"),))
    entry = {name: c.strip() for name, c in zip(names, cells, strict=True) if c.strip()}
    try:
        return Row(line, kept, _from_row(entry, place))
    except ValidationError as error:
        return Row(line, kept, None, tuple(sentences(_of_row(error, names), partial(_line, line))))


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are not empty, each with the line that it ends on."""
    header = text.partition("\n")[0]
    # Where decimals have commas, cells are parted by something else.
    delimiter = next((sign for sign in ";\t" if sign in header), ",")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    for cells in reader:
        if any(cell.strip() for cell in cells):
            yield reader.line_num, cells


def _line(line: int, _place: Place) -> int:
    """Return the line of a row: all its cells stand there."""
    return line


def _wrong_names(names: list[str]) -> Iterator[str]:
    """Yield what is wrong with a header's names."""
    for name in dict.fromkeys(names):
        if name not in KNOWN:
            yield f"{name or 'a column without a name'}: expected one of {', '.join(KNOWN)}"
        elif names.count(name) > 1:
            yield f"{name}: is there {names.count(name)} times; expected it once"
    for name in NEEDED:
        if name not in names:
            yield f"{name}: is missing"


def _from_row(entry: Mapping[str, str], place: int) -> Column:
    own = {name: cell for name, cell in entry.items() if name in Summary.model_fields}
    scale = {name: entry[SCALE + name] for name in Scale.model_fields if SCALE + name in entry}
    return Column.model_validate({"label": f"column {place}", **own, "scale": scale})


def _of_row(error: ValidationError, names: list[str]) -> Iterator[Fault]:
    """Yield the faults of a row in the header's words; what the header lacks is told there."""
    for place, fault in faults_in(error):
        of_scale = place[0] == "scale" and len(place) > 1
        name = f"{SCALE}{place[1]}" if of_scale else str(place[0])
        if name in names or fault["type"] != "missing":
            yield (name,), fault


KNOWN = (*Summary.model_fields, *(SCALE + name for name in Scale.model_fields))
NEEDED = ("n", "mean", "sd", f"{SCALE}maximum")
