"""Fuzz code books, which must code any report or be rejected with an error message."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

from slipscale.analysis.tasks.difference.verbal_coding import OTHER, SHIPPED, load_codebook
from slipscale.faults import UserError
from tests.fuzzing.changes import changed_file, characters
from tests.fuzzing.kind import Case, Kind

REPORTS = ("", "moins glissant, plus rugueux", "less slippery", "x" * 5000)


def _prepared(folder: Path) -> Callable[[Random], Case]:
    path = folder / "codebook.toml"
    text = SHIPPED.read_text(encoding="utf-8")

    def drawn(random: Random) -> Case:
        content = changed_file(random, text)
        report = random.choice((*REPORTS, characters(random, 40)))
        return Case(name=path.name, content=content, use=lambda: _use(path, content, report))

    return drawn


def _use(path: Path, content: bytes, report: str) -> bool:
    path.write_bytes(content)
    try:
        book = load_codebook(path)
    except UserError as error:
        if str(path) not in str(error):
            raise AssertionError(f"the error does not name the file: {error}") from error
        return False
    found = book.code(report)
    directions = {book.direction(report, each) for each in found if each != OTHER}
    if not found or not directions <= {"less", "more", "bare"}:
        raise AssertionError(f"{report!r}: codes {found}, directions {directions}")
    return True


KIND = Kind(title="code books", prepared=_prepared)
