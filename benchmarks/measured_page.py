"""Replace tables on the page of measured statistics, found by the comments around them."""

from __future__ import annotations

from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "validation" / "measured" / "statistics.md"


def put(name: str, lines: list[str]) -> None:
    """Replace a table on the page with the given lines."""
    start, end = (f"<!-- {name}: {edge} -->" for edge in ("begin", "end"))
    text = PAGE.read_text(encoding="utf-8")
    before, after = text.split(start)[0], text.split(end)[1]
    body = "\n".join(lines)
    PAGE.write_text(f"{before}{start}\n{body}\n{end}{after}", encoding="utf-8")
