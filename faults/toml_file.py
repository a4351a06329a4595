"""Read and validate TOML files, and report all errors with their lines."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.toml_lines import Lines, Place
from slipscale.faults.validation import (
    Fault,
    Names,
    Told,
    complaint,
    fault_at,
    faults_in,
    sentences,
)

if TYPE_CHECKING:
    from pydantic import BaseModel

    Model = TypeVar("Model", bound=BaseModel)

AT = re.compile(r"\(at (?:line (\d+), column \d+|end of document)\)")
# Error messages with the expected syntax, keyed by the start of tomllib's message.
CAUSES = {
    "Invalid value": 'expected a value: words in "quotes", a number, true or false, or a [list]',
    "Expected '=' after a key": "expected key = value",
    "Invalid statement": "expected key = value, or [table]",
    "Expected newline or end of document": "expected nothing more after the value",
    "Cannot overwrite a value": "the key is given twice",
    "Unclosed array": "a list is not closed; expected ] after the last item",
    "Cannot declare": "the table is given twice",
    "Expected ']' at the end of a table declaration": "expected ] after the table's name",
}
# Pattern for two integers in a list that are separated by a comma without a space.
TIGHT_COMMA = re.compile(r"=\s*\[[^\].]*?(-?\d+,\d+)")
# Limits on the nesting of tables and on the length of integers.
DEEPEST = 20
MOST_DIGITS = 300
TOO_LARGE = 10**MOST_DIGITS


def read_toml(
    path: Path,
    model: type[Model],
    *,
    names: Callable[[dict[str, object]], Names] | None = None,
) -> Model:
    """Read a TOML file as a pydantic model.

    Parameters
    ----------
    path : Path
        Path of a UTF-8 file, with or without a byte-order mark.
    model : type
        Pydantic model of the whole file.
    names : callable, optional
        Function that takes the content of the file and returns a mapping between keys and field
        names. By default, each key has the name of its field.

    Raises
    ------
    UserError
        If the file cannot be read, is not TOML, or does not fit the model. The message has one line
        per error, with its position, the invalid value and the expected value.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        if "\0" in str(path):
            reason = "a file name cannot contain a null character"
        raise UserError(
            "{path}: cannot be read ({reason}); expected a TOML file", path=path, reason=reason
        ) from None
    return parse_toml(text, str(path), model, names=names)


def parse_toml(
    text: str,
    source: str,
    model: type[Model],
    *,
    parse_float: Callable[[str], object] = float,
    names: Callable[[dict[str, object]], Names] | None = None,
) -> Model:
    """Parse TOML as `read_toml` does, with ``source`` as the file name in error messages."""
    from pydantic import ValidationError

    table = toml_table(text, source, parse_float=parse_float)
    known = names(table) if names else None
    try:
        return model.model_validate(known.to_code(table) if known else table, context=known)
    except ValidationError as error:
        faults = sentences(faults_in(error, model, known), Lines(text).of)
        raise complaint(source, _decimal_commas(faults, text)) from None


def toml_table(
    text: str, source: str, *, parse_float: Callable[[str], object] = float
) -> dict[str, object]:
    """Parse TOML into a table, without validating it against a model.

    Raises
    ------
    UserError
        If the text is not TOML, is nested too deeply, or contains extremely large numbers.
    """
    table = _table(text, source, parse_float)
    if faults := list(_beyond_reason(table)):
        raise complaint(source, sentences(faults, Lines(text).of))
    return table


def _table(text: str, source: str, parse_float: Callable[[str], object]) -> dict[str, object]:
    try:
        return tomllib.loads(text, parse_float=parse_float)
    except tomllib.TOMLDecodeError as error:
        raise complaint(source, [not_toml(text, str(error))]) from None
    except RecursionError:
        raise UserError(
            "{source} has too many nested brackets; expected at most {deepest}",
            source=source,
            deepest=DEEPEST,
        ) from None
    except ValueError:
        # Python does not read integers with thousands of digits.
        number = max(re.finditer(r"\d[\d_]*", text), key=lambda found: len(found[0]))
        line = text.count("\n", 0, number.start()) + 1
        whole = Message(
            "line {line}: a number can have at most {most} digits", line=line, most=MOST_DIGITS
        )
        raise complaint(source, [Told(line, (), whole, whole)]) from None


def not_toml(text: str, said: str) -> Told:
    """Return the fault of invalid TOML, from the message of tomllib.

    >>> not_toml('name = "a', "Illegal character (at line 1, column 10)").whole
    'line 1 is not TOML: a quotation mark is not closed; expected text between two quotation marks'
    """
    lines = text.split("\n")
    found = AT.search(said)
    number = min(int(found[1]), len(lines)) if found and found[1] else len(lines)
    line = lines[number - 1]
    quotes = re.sub(r"\\.|#[^\"']*$", "", line)
    if (
        '"""' not in text
        and "'''" not in text
        and (quotes.count('"') % 2 or (quotes.count("'") % 2 and '"' not in quotes))
    ):
        why = "a quotation mark is not closed; expected text between two quotation marks"
    elif re.search(r"=\s*-?\d+,\d", line):
        why = "a decimal number has a comma; expected a point, such as 0.5"
    else:
        cause = AT.sub("", said).strip()
        why = next((ours for theirs, ours in CAUSES.items() if cause.startswith(theirs)), cause)
    whole = Message("line {line} is not TOML: {why}", line=number, why=why)
    return Told(number, (), whole, whole)


def _decimal_commas(faults: list[Told], text: str) -> list[Told]:
    """Keep one error per list that probably contains decimal commas, and explain the commas."""
    lines = text.split("\n")
    found: dict[int, Told] = {}
    rest = []
    for fault in faults:
        comma = TIGHT_COMMA.search(lines[fault.line - 1]) if fault.line else None
        if comma is None or fault.kind == "extra_forbidden":  # The error is not in the list.
            rest.append(fault)
        elif fault.line not in found:
            message = Message(
                "{message}; commas separate the items of a list: if {typed} is one number, write "
                "{number}",
                message=fault.message,
                typed=comma[1],
                number=comma[1].replace(",", "."),
            )
            found[fault.line] = fault_at(fault.line, fault.place, message)
    return [*rest, *found.values()]


def _beyond_reason(table: dict[str, object]) -> Iterator[Fault]:
    """Yield a fault for each value that is nested too deeply or is too large."""
    todo: list[tuple[Place, object]] = [((), table)]
    while todo:
        place, value = todo.pop()
        if isinstance(value, int) and abs(value) >= TOO_LARGE:
            yield (
                place,
                {"msg": Message("expected a number of at most {most} digits", most=MOST_DIGITS)},
            )
        if isinstance(value, dict | list) and value and len(place) >= DEEPEST:
            yield (
                place[:1],
                {
                    "msg": Message(
                        "expected tables and lists nested at most {deepest} deep", deepest=DEEPEST
                    )
                },
            )
        elif isinstance(value, dict):
            todo += [((*place, key), inner) for key, inner in value.items()]
        elif isinstance(value, list):
            todo += [((*place, number), inner) for number, inner in enumerate(value)]
