"""A TOML file as a model: read, validated whole, and every fault told at once, with its line."""

from __future__ import annotations

import re
import tomllib
from typing import TYPE_CHECKING, TypeVar

from slipscale.faults import UserError
from slipscale.faults.toml_lines import Lines
from slipscale.faults.validation import complaint, faults_in, sentences

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from pydantic import BaseModel

    from slipscale.faults.toml_lines import Place
    from slipscale.faults.validation import Fault

    Model = TypeVar("Model", bound=BaseModel)

# No file of ours has tables within tables so often, or whole numbers so long.
DEEPEST = 20
MOST_DIGITS = 300
TOO_LARGE = 10**MOST_DIGITS


def read_toml(
    path: Path, model: type[Model], *, parse_float: Callable[[str], object] = float
) -> Model:
    """Return what a TOML file says, as a pydantic model.

    Parameters
    ----------
    path : Path
        The file: UTF-8, with or without the mark that Windows' editors begin with.
    model : type
        A pydantic model of the whole file.
    parse_float : callable
        What becomes of a bare decimal number; ``str`` keeps it as it is written.

    Raises
    ------
    UserError
        The file cannot be read, is not TOML, or does not fit the model: one message with a line
        for every fault, which says where it is, what was found and what was expected.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        if "\0" in str(path):
            reason = "no file's name has a null character"
        raise UserError(f"{path}: cannot be read ({reason}); expected a TOML file") from None
    return parse_toml(text, str(path), model, parse_float=parse_float)


def parse_toml(
    text: str, source: str, model: type[Model], *, parse_float: Callable[[str], object] = float
) -> Model:
    """Return what a TOML text says, as `read_toml` does; ``source`` is its name for messages."""
    from pydantic import ValidationError  # noqa: PLC0415 - whoever has a model has loaded it

    table = toml_table(text, source, parse_float=parse_float)
    try:
        return model.model_validate(table)
    except ValidationError as error:
        raise complaint(source, sentences(faults_in(error), Lines(text).of)) from None


def toml_table(
    text: str, source: str, *, parse_float: Callable[[str], object] = float
) -> dict[str, object]:
    """Return what a TOML text says, where no model knows all that may stand in it.

    Raises
    ------
    UserError
        It is not TOML, or is nested too deeply or has numbers too large for any use.
    """
    table = _table(text, source, parse_float)
    if faults := list(_beyond_reason(table)):
        raise complaint(source, sentences(faults, Lines(text).of))
    return table


def _table(text: str, source: str, parse_float: Callable[[str], object]) -> dict[str, object]:
    try:
        return tomllib.loads(text, parse_float=parse_float)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{source} is not TOML: {error}") from None
    except RecursionError:
        raise UserError(
            f"{source} has brackets within brackets too often; expected at most {DEEPEST}"
        ) from None
    except ValueError:
        # Python itself refuses to read decimal numbers of thousands of digits.
        number = max(re.finditer(r"\d[\d_]*", text), key=lambda found: len(found[0]))
        line = text.count("\n", 0, number.start()) + 1
        told = f"line {line}: expected numbers of at most {MOST_DIGITS} digits"
        raise UserError(f"{source} has a fault:\n  {told}") from None


def _beyond_reason(table: dict[str, object]) -> Iterator[Fault]:
    """Yield what is nested too deeply or too large to compute with, whatever the model."""
    todo: list[tuple[Place, object]] = [((), table)]
    while todo:
        place, value = todo.pop()
        if isinstance(value, int) and abs(value) >= TOO_LARGE:
            yield place, {"msg": f"expected a number of at most {MOST_DIGITS} digits"}
        if isinstance(value, dict | list) and value and len(place) >= DEEPEST:
            yield place[:1], {"msg": f"expected tables and lists at most {DEEPEST} deep"}
        elif isinstance(value, dict):
            todo += [((*place, key), inner) for key, inner in value.items()]
        elif isinstance(value, list):
            todo += [((*place, number), inner) for number, inner in enumerate(value)]
