"""Upload a laboratory's own table, describe it with the chosen options, and analyse it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from subprocess import TimeoutExpired
from typing import Annotated, Literal

from pydantic import Base64Bytes, Field

from slipscale.experiments.lab.console.actions.desk import Actions, Desk
from slipscale.experiments.lab.console.actions.forms import Form
from slipscale.experiments.lab.console.own_tables import (
    MAPPING,
    Code,
    Number,
    Role,
    about,
    description_of,
    folder_of,
    keep,
    remove,
    table_in,
)
from slipscale.experiments.lab.console.state import RESULTS
from slipscale.faults import UserError
from slipscale.faults.message import Message

LONGEST_S = 5.0  # time to wait for the end of the previous description
Name = Annotated[str, Field(min_length=1, max_length=1000)]


class File(Form):
    """A file that the page has read."""

    name: Name
    content: Base64Bytes


class Upload(Form):
    """Add a table, which may consist of several files with the same columns."""

    tables: Annotated[list[File], Field(min_length=1, max_length=1000)]


class Choices(Form):
    """The chosen meaning of a table's columns; without roles and layout, it is proposed again.

    Parameters
    ----------
    roles : dict
        What each column contains; empty if it is not used.
    codes : dict
        What the codes in the column of answers mean.
    layout : bool
        Whether to use the arrangement that the description proposes.
    sheet : str
        Sheet of a workbook with several.
    """

    number: Number
    roles: dict[Name, Role | Literal[""]] = Field(default_factory=dict)
    codes: dict[Name, Code] = Field(default_factory=dict)
    unit: Annotated[str, Field(max_length=40)] = ""
    alternatives: Literal["", "2", "3"] = ""
    layout: bool = False
    sheet: Annotated[str, Field(max_length=200)] = ""


class Remove(Form):
    """Remove a table with its report."""

    number: Number


def _upload(desk: Desk, request: Upload) -> str:
    folder = keep([(table.name, table.content) for table in request.tables])
    return _describe(desk, Choices(number=folder.name))


def _describe(desk: Desk, request: Choices) -> str:
    folder = folder_of(request.number)
    _start(desk, "describe", folder, "--describe", *options(request, folder))
    return "reading the table"


def _report(desk: Desk, request: Choices) -> str:
    folder = folder_of(request.number)
    chosen = options(request, folder)
    (folder / "table" / MAPPING).unlink(missing_ok=True)  # the report saves the new choices
    _start(desk, "report", folder, "--steps", *chosen, *(["--map"] if chosen else []))
    return "analysing"


def _start(desk: Desk, kind: Literal["describe", "report"], folder: Path, *words: str) -> None:
    out = str(folder / RESULTS)
    table = str(table_in(folder))
    if before := desk.jobs.last("describe"):
        # The page shows a description a moment before its command ends.
        with suppress(TimeoutExpired):
            before.process.wait(LONGEST_S)
    desk.jobs.start(kind, about(folder.name), "analyse", table, "--out", out, *words)


def _remove(desk: Desk, request: Remove) -> str:
    folder = folder_of(request.number)
    for kind in ("describe", "report"):
        job = desk.jobs.last(kind)
        if job and job.running:
            raise UserError("{about}: still running; wait until it is finished", about=job.about)
    remove(folder)
    return Message("removed: {what}", what=about(request.number))


def options(request: Choices, folder: Path) -> list[str]:
    """Return the options of ``slipscale analyse`` for the choices.

    Raises
    ------
    UserError
        If two columns have the same use.
    """
    columns = _columns(request.roles)
    described = description_of(folder) if request.layout else None
    layout = described.layout if described else {}
    unit, stimulus = request.unit.strip(), columns.get("stimulus", "")
    if (columns or layout) and (unit or ":" in stimulus):
        columns["stimulus"] = f"{stimulus}:{unit}"
    words = [f"{_option(role)}={column}" for role, column in columns.items()]
    if words and request.alternatives:
        words.append(f"--alternatives={request.alternatives}")
    words += [word for name, value in layout.items() for word in _words(name, value)]
    for meaning in ("yes", "no", "missing"):
        codes = [code for code, meant in request.codes.items() if meant == meaning]
        if codes and "answer" in columns:
            words += _words(meaning, tuple(codes))
    return [*words, *(_words("sheet", request.sheet) if request.sheet else [])]


def _columns(roles: dict[str, Role | Literal[""]]) -> dict[str, str]:
    """Return the column for each use."""
    columns: dict[str, str] = {}
    for column, role in roles.items():
        if role in columns:
            raise UserError(
                "columns {first} and {second} have the same use; choose it for only one of them",
                first=columns[role],
                second=column,
            )
        if role:
            columns[role] = column
    return columns


def _words(name: str, value: bool | str | tuple[str, ...]) -> list[str]:
    """Return an option with its values."""
    if isinstance(value, tuple):
        option = next((each for each in value if each.startswith("--")), None)
        if option is not None:
            raise UserError(
                "'{option}' would be read as an option; rename this code", option=option
            )
        return [_option(name), *value]
    return [_option(name)] if value is True else [f"{_option(name)}={value}"]


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


ACTIONS: Actions = {
    "upload": (Upload, _upload),
    "describe": (Choices, _describe),
    "report": (Choices, _report),
    "remove": (Remove, _remove),
}
