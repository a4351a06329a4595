"""The index of decisions, from the first lines of each."""

from __future__ import annotations

import re
from pathlib import Path

from tools.site.tables import table

FOLDER = Path(__file__).parents[2] / "docs" / "decisions"
INTRODUCTION = """# Decisions

Why things are as they are: a page for each decision that a successor would question. The wings of
the house have number ranges of their own, hence the gaps. A page is never rewritten to say the
opposite: a new one says so, and the old one's status names it.
"""


def pages() -> dict[str, str]:
    """Return the index."""
    rows = [row(path) for path in sorted(FOLDER.glob("*.md"))]
    listed = table(["number", "decision", "status", "date"], rows)
    return {"decisions/index.md": f"{INTRODUCTION}\n{listed}\n"}


def row(path: Path) -> list[str]:
    """Return a decision's line: number, title with its link, status, date."""
    title, _, status = path.read_text(encoding="utf-8").splitlines()[:3]
    number, words = re.split(r"[ :]+", title.removeprefix("# "), maxsplit=1)
    status, _, date = status.rstrip(".").rpartition(", ")
    return [number, f"[{words[0].upper()}{words[1:]}]({path.name})", status, date]
