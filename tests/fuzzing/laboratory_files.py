"""Fuzz ``slipscale.toml``, which must be read, or rejected with an error message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

from slipscale.experiments.lab.folder import FILE, LabFile, read_lab, rendered
from slipscale.faults import UserError
from slipscale.hardware.registry import backend_names
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind

GIVEN = {"plate": "serial:COM3", "language": "fr", "screen": "1", "backup": "copies"}


def _prepared(folder: Path) -> Callable[[Random], Case]:
    text = rendered(GIVEN)
    bare = "\n".join(line for line in text.splitlines() if line and line[0] != "#")

    def drawn(random: Random) -> Case:
        content = changed_file(random, random.choice((text, bare)))
        return Case(name=FILE, content=content, use=lambda: _use(folder, content))

    return drawn


def _use(folder: Path, content: bytes) -> bool:
    (folder / FILE).write_bytes(content)
    try:
        lab = read_lab(folder)
    except UserError as error:
        if FILE not in str(error):
            raise AssertionError(f"the error does not name the file: {error}") from error
        return False
    if not isinstance(lab, LabFile) or lab.plate.partition(":")[0] not in backend_names():
        raise AssertionError(f"{lab}")
    return True


KIND = Kind(title="laboratory folders (slipscale.toml)", prepared=_prepared)
