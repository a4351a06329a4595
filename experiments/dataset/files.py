"""Files of a data set, written whole or not at all."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from slipscale.experiments.journal.journal import AS_USUAL, OWNER_ONLY
from slipscale.faults import UserError

if TYPE_CHECKING:
    from pathlib import Path

# A file's bytes, its text, or the object that a JSON file holds.
Content = bytes | str | dict[str, Any]


def draft_of(path: Path) -> Path:
    """Return where a file or folder is written before it gets its name."""
    return path.with_name(f".{path.name}.tmp")


def write_file(
    path: Path, content: Content, *, private: bool = False, durable: bool = False
) -> None:
    """Write a file whole or not at all.

    Parameters
    ----------
    private : bool
        Whether the file is for its owner alone.
    durable : bool
        Whether to wait for the disk.

    Raises
    ------
    UserError
        It cannot be written.
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
        raise UserError(f"{path}: cannot be written ({error.strerror})") from None
