"""Edit pages of measured tables: each table lies between two comments with its name."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[1] / "docs" / "validation" / "measured"


def put(page: str, name: str, lines: list[str]) -> None:
    """Replace a table of a page, such as ``coverage.md``, by the given lines."""
    path, (start, end) = FOLDER / page, (f"<!-- {name}: {edge} -->" for edge in ("begin", "end"))
    text = path.read_text(encoding="utf-8")
    before, after = text.split(start)[0], text.split(end)[1]
    body = "\n".join(lines)
    path.write_text(f"{before}{start}\n{body}\n{end}{after}", encoding="utf-8")
