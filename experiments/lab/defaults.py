"""Command defaults: the laboratory folder's settings or, without one, built-in defaults.

Because the parsers of all commands import this module, it imports modules outside the standard
library only if there is a ``slipscale.toml``.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FILE = Path("slipscale.toml")
REHEARSALS = "rehearsals"


@dataclass(frozen=True, slots=True, kw_only=True)
class Defaults:
    """Defaults of the commands; see `slipscale.experiments.lab.folder.LabFile`.

    ``file`` is None outside a laboratory folder.
    """

    file: Path | None = None
    study: str = "biet2007"
    plate: str = "mock"
    screen: int = 0
    windowed: bool = False
    language: str | None = None
    markers: tuple[str, ...] = ()
    position: str | None = None
    force: str | None = None
    sound_required: bool = False
    data: Path = Path("data")
    pilots: Path = Path("pilots")
    backup: Path | None = None

    def out(self, *, pilot: bool) -> Path:
        """Return the output folder for runs with participants, or for rehearsals (pilots)."""
        return self.pilots / REHEARSALS if pilot else self.data


def here() -> Defaults:
    """Return the defaults in the current folder; parent folders are not searched.

    Raises
    ------
    UserError
        If the folder's ``slipscale.toml`` is invalid.
    """
    if not FILE.exists():
        return Defaults()
    from slipscale.experiments.lab.folder import read_lab

    lab = read_lab(Path())
    if lab is None:  # the file was deleted in the meantime
        return Defaults()
    return Defaults(
        file=FILE.resolve(),
        study=lab.study,
        plate=lab.plate,
        screen=lab.screen,
        windowed=lab.windowed,
        language=lab.language or None,
        markers=lab.markers,
        position=lab.position or None,
        force=lab.force or None,
        sound_required=lab.sound_required,
        data=Path(lab.data),
        pilots=Path(lab.pilots),
        backup=Path(lab.backup) if lab.backup else None,
    )


def dataset_default() -> dict[str, Any]:
    """Return parser options that make the data set optional in a laboratory folder."""
    defaults = here()
    return {"nargs": "?", "default": defaults.data} if defaults.file else {}


def say(defaults: Defaults) -> None:
    """Print to standard error which file contains the defaults, if any."""
    if defaults.file:
        print(f"defaults: {defaults.file}", file=sys.stderr)
