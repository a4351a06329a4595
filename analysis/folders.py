"""The folder that a command writes into, made before anything takes time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from faults import UserError

if TYPE_CHECKING:
    from pathlib import Path


def make_folder(out: Path) -> None:
    """Make the folder for the output.

    Raises
    ------
    UserError
        There is a file of that name, or the folder cannot be made.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise UserError(f"{out}: is a file; expected a folder for the output") from error
    except OSError as error:
        raise UserError(f"{out}: cannot be made ({error.strerror})") from error
