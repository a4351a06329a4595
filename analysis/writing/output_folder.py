"""The folder that a command writes into, made before anything takes time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.analysis.reading.dataset import Dataset


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


def default_folder(data: Dataset, source: str | Path) -> Path:
    """Return where the output goes when the user does not say.

    ``derivatives/slipscale`` in a data set; beside a tidy table a folder with its name and
    ``-slipscale``.
    """
    if data.folder is not None:
        return data.folder / "derivatives" / "slipscale"
    path = Path(source)
    return path.with_name(f"{path.stem}-slipscale")
