"""Write files of a data set atomically: completely or not at all."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from slipscale.experiments.journal.journal import AS_USUAL, OWNER_ONLY
from slipscale.faults import UserError

# The content of a file: bytes, text, or an object to be written as JSON.
Content = bytes | str | dict[str, Any]


def draft_of(path: Path) -> Path:
    """Return the path at which a file or folder is written before it is complete and renamed."""
    return path.with_name(f".{path.name}.tmp")


def missing_lines(path: Path, content: str) -> bytes:
    """Return the lines of a text that an existing or new file does not contain yet."""
    lines = path.read_bytes().splitlines() if path.exists() else []
    wanted = content.encode().splitlines(keepends=True)
    return b"".join(each for each in wanted if each.rstrip() not in lines)


def write_file(
    path: Path, content: Content, *, private: bool = False, durable: bool = False
) -> None:
    """Write a file atomically.

    Parameters
    ----------
    private : bool
        Whether the file can be read and written only by its owner.
    durable : bool
        Whether to flush the file to disk.

    Raises
    ------
    UserError
        If the file cannot be written.
    """
    if isinstance(content, dict):
        content = json.dumps(content, indent=2) + "\n"
    line = content if isinstance(content, bytes) else content.encode()
    draft = draft_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        draft.touch(OWNER_ONLY if private else AS_USUAL)
        draft.write_bytes(line)
        if durable:
            with draft.open("rb+") as stream:
                os.fsync(stream.fileno())
        os.replace(draft, path)  # noqa: PTH105 - Path.replace is the same call
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise UserError(
            "{path}: cannot be written ({reason})", path=path, reason=error.strerror
        ) from None
