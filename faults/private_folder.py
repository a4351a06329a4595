"""A private folder for files of running programs, which other users cannot access."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path

from slipscale.faults import UserError

OWNER_ONLY = 0o700


def private_folder() -> Path:
    """Return the private folder; create it if necessary.

    The private folder is located in the system's folder for runtime files or, if there is none, in
    the user's cache.

    Raises
    ------
    UserError
        If no folder can be created that only this user can access.
    """
    places = (os.environ.get("XDG_RUNTIME_DIR"), str(Path.home() / ".cache"))
    for place in filter(None, places):
        folder = Path(place, "slipscale")
        try:
            folder.mkdir(mode=OWNER_ONLY, parents=True, exist_ok=True)
            if _is_private(folder):
                return folder
        except OSError:
            continue
    raise UserError(
        "{folder}: expected a folder that only you can read and write; remove it, or restrict it "
        "to yourself (chmod 700)",
        folder=Path.home() / ".cache" / "slipscale",
    )


def write_private(path: Path, text: str) -> None:
    """Replace a file's content; only the owner can read the file."""
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
        stream.write(text)


def _is_private(folder: Path) -> bool:
    """Return whether a path is a real folder that only this user can access."""
    if sys.platform == "win32":
        return True
    found = folder.lstat()
    closed = not found.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and closed
