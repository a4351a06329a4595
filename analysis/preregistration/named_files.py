"""Find the files that a study file refers to.

A string in the study file is treated as a file name if such a file exists, so new study keys need
no change in this module. If that file is a TOML file, its strings are treated in the same way: a
plate file, for example, names its calibration.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from slipscale.faults import UserError
from slipscale.hardware.plate_file import path_of

#: Key whose file may be given by its name alone, without folder and extension.
PLATE = "plate.file"
LONGEST = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedFile:
    """A file, and the key that refers to it (for nested files, all keys joined by ``>``)."""

    key: str
    path: Path
    content: bytes


def named_files(text: str, beside: Path | None) -> list[NamedFile]:
    """Return the files to which a study refers, without duplicates, in the order of their keys.

    Parameters
    ----------
    text : str
        Text of a valid study file.
    beside : Path or None
        Folder of the study file; None for a study that comes with Slipscale.

    Raises
    ------
    UserError
        If a file cannot be read.
    """
    found: dict[Path, NamedFile] = {}
    folders = [Path(), *([beside] if beside else [])]
    _gather(tomllib.loads(text), folders, "", found)
    return list(found.values())


def _gather(
    table: dict[str, object], folders: list[Path], prefix: str, found: dict[Path, NamedFile]
) -> None:
    for key, text in _texts(table, ""):
        path = _file(key, text, folders)
        if path is None or path.resolve() in found:
            continue
        try:
            content = path.read_bytes()
        except OSError as error:
            raise UserError(
                "{path}: cannot be read ({reason}); the study's {key} names this file",
                path=path,
                reason=error.strerror,
                key=key,
            ) from None
        found[path.resolve()] = NamedFile(key=f"{prefix}{key}", path=path, content=content)
        if path.suffix == ".toml":
            try:
                inner = tomllib.loads(content.decode("utf-8-sig"))
            except (tomllib.TOMLDecodeError, UnicodeDecodeError):
                continue  # errors in it are reported by the code that uses the file
            _gather(inner, [path.parent, *folders], f"{prefix}{key} > ", found)


def _texts(value: object, key: str) -> Iterator[tuple[str, str]]:
    """Yield the key and value of every string in a table."""
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _texts(inner, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list):
        for number, inner in enumerate(value, start=1):
            yield from _texts(inner, f"{key}.{number}")


def _file(key: str, text: str, folders: list[Path]) -> Path | None:
    """Return the path of the named file, or None if it does not exist."""
    if key == PLATE and text:
        return path_of(text, Path())
    # A word without an extension is not treated as a file name, even if such a file exists.
    if not text or len(text) > LONGEST or "\n" in text or not Path(text).suffix:
        return None
    try:
        return next((folder / text for folder in folders if (folder / text).is_file()), None)
    except (OSError, ValueError):
        return None
