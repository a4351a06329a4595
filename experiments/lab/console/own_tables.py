"""A laboratory's own tables: their folder, and their descriptions by ``slipscale analyse``.

Each table has a folder ``tables/NNN`` that only its owner can read. It contains the table in
``table`` (with ``analysis.toml`` once a report was requested), and the description and the report
in ``derivatives/slipscale``.
"""

from __future__ import annotations

import json
import re
import shutil
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Literal, get_args

from pydantic import Field, PlainValidator, ValidationError

from slipscale.experiments.dataset.files import write_file
from slipscale.experiments.lab.console.state import RESULTS
from slipscale.faults import UserError, harmless
from slipscale.faults.folders import visible
from slipscale.faults.frozen_table import FrozenTable
from slipscale.faults.message import Message, from_data

TABLES = Path("tables")
MAPPING = "analysis.toml"
DESCRIPTION = "description.json"
LARGEST_MB = 10
NUMBER = "^[0-9]{3,9}$"
# What a column can contain; the options of slipscale analyse have these names.
Role = Literal[
    "participant",
    "stimulus",
    "response",
    "answer",
    "yes_count",
    "no_count",
    "percent",
    "n",
    "reference",
    "first",
    "second",
    "chosen",
    "dissimilarity",
    "group",
    "factor",
    "session",
    "run",
    "block",
    "trial",
]
ROLES: tuple[Role, ...] = get_args(Role)
# What a code in the column of answers can mean; empty if this is not stated.
Code = Literal["", "yes", "no", "missing"]
CODES: tuple[Code, ...] = get_args(Code)


class Column(FrozenTable):
    """A column of a table: its values, and its cells in the first rows."""

    name: str
    values: tuple[str, ...]
    distinct: int
    missing: int
    range: tuple[float, float] | None
    head: tuple[str, ...]


class Amounts(FrozenTable):
    """The consequence of the choices."""

    answers: int
    people: int
    levels: int


class Description(FrozenTable):
    """What ``slipscale analyse --describe --json`` writes; see the command's source."""

    name: str
    program: str
    files: int
    sheets: tuple[str, ...]
    sheet: str
    rows: int
    columns: tuple[Column, ...]
    own: bool
    roles: dict[Role, str]
    unit: str
    codes: dict[str, Code]
    alternatives: int | None
    layout: dict[str, bool | str | tuple[str, ...]]
    open: tuple[str, ...]
    candidates: dict[str, tuple[str, ...]]
    amounts: Amounts | None
    # pydantic's own validator would reduce a message to its text.
    fault: Annotated[str, PlainValidator(lambda data: harmless(from_data(data)))]
    command: str


def tables() -> list[Path]:
    """Return the folders of all tables, newest first."""
    found = [path for path in visible(TABLES, "[0-9]*") if re.match(NUMBER, path.name)]
    return sorted(found, key=lambda path: int(path.name), reverse=True)


def folder_of(number: str) -> Path:
    """Return the folder of a table; raise `UserError` if there is none."""
    for path in tables():
        if path.name == number:
            return path
    raise UserError("table {number} no longer exists; reload the page", number=number)


def table_in(folder: Path) -> Path:
    """Return the path of the table in its folder; for several files, the path of their folder."""
    files = [path for path in visible(folder / "table", "*") if path.name != MAPPING]
    if files:
        return files[0] if len(files) == 1 else folder / "table"
    raise UserError("table {number} no longer exists; reload the page", number=folder.name)


def keep(uploaded: Sequence[tuple[str, bytes]]) -> Path:
    """Write the uploaded files of a table into a new folder, which is returned.

    Raises
    ------
    UserError
        If a file is empty, files are too large or have the same name, or they cannot be written.
    """
    files = {file_name(name): content for name, content in uploaded}
    if not all(files.values()):
        raise UserError("the file is empty; choose the file with the table")
    if len(files) < len(uploaded):
        raise UserError("two files have the same name; rename one of them")
    if sum(map(len, files.values())) > LARGEST_MB * 1_000_000:
        raise UserError(
            "the file is larger than {most} MB; analyse it with slipscale analyse in a terminal",
            most=LARGEST_MB,
        )
    number = max((int(path.name) for path in tables()), default=0) + 1
    folder = TABLES / f"{number:03d}"
    try:
        TABLES.mkdir(mode=stat.S_IRWXU, exist_ok=True)
        for each in (folder, folder / "table"):
            each.mkdir(mode=stat.S_IRWXU)
    except OSError as error:
        raise UserError(
            "{path}: cannot be written ({reason})", path=folder, reason=error.strerror
        ) from None
    for name, content in files.items():
        write_file(folder / "table" / name, content, private=True)
    return folder


def file_name(name: str) -> str:
    """Return a safe name for a file, with the same ending.

    >>> file_name("../Étude 1.csv"), file_name("analysis.toml")
    ('tude_1.csv', 'table.toml')
    """
    plain = re.sub("[^A-Za-z0-9._-]+", "_", name)[-80:].lstrip("._-")
    return plain.replace("analysis.toml", "table.toml") or "table"


def description_of(folder: Path) -> Description | None:
    """Read the description of a table; return None if there is none yet."""
    try:
        text = (folder / RESULTS / DESCRIPTION).read_text(encoding="utf-8")
        return Description.model_validate(json.loads(text))
    except (OSError, ValueError, ValidationError):
        return None


def remove(folder: Path) -> None:
    """Delete a table with its description and report."""
    try:
        shutil.rmtree(folder)
    except OSError as error:
        raise UserError(
            "{path}: cannot be removed ({reason})", path=folder, reason=error.strerror
        ) from None


def values_in(text: str) -> Iterator[str]:
    """Yield the texts that were inserted into a message, at any depth."""
    if isinstance(text, Message):
        for value in text.values.values():
            if isinstance(value, str):
                yield value
                yield from values_in(value)


def about(number: str) -> Message:
    """Return the name of a job on a table."""
    return Message("table {number}", number=number)


Number = Annotated[str, Field(pattern=NUMBER)]
