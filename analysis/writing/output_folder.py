"""Create the output folder of a command before its computation starts."""

from __future__ import annotations

import stat
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.dataset import Dataset


OF_OTHERS = stat.S_IRWXG | stat.S_IRWXO
PEOPLE = "participants.tsv"


def make_folder(out: Path) -> None:
    """Create the output folder, with private access if it is in a private data set.

    Raises
    ------
    UserError
        If the path is a file, or the folder cannot be created.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        for people in (folder / PEOPLE for folder in out.parents):
            if people.exists() and not people.stat().st_mode & OF_OTHERS:
                out.chmod(stat.S_IRWXU)
    except FileExistsError as error:
        raise UserError("{out}: is a file; expected a folder for the output", out=out) from error
    except OSError as error:
        raise UserError(
            "{out}: cannot be created ({reason})", out=out, reason=error.strerror
        ) from error


def default_folder(data: Dataset, source: str | Path) -> Path:
    """Return the default output folder.

    For a data set, this is its folder ``derivatives/slipscale``. For a tidy table ``NAME.csv``,
    this is the folder ``NAME-slipscale`` next to the table.
    """
    if data.folder is not None:
        return data.folder / "derivatives" / "slipscale"
    path = Path(source)
    name = "standard-input" if path == Path("-") else path.stem
    return path.with_name(f"{name}-slipscale")
