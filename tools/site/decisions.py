"""The index of decisions, from the first lines of each.

``python -m tools.site.decisions`` gives a new page its status and the date of its first commit.
"""

from __future__ import annotations

import re
import subprocess
from datetime import UTC, datetime
from pathlib import Path

from tools.site.tables import table

FOLDER = Path(__file__).parents[2] / "docs" / "decisions"
# The third line of a page; the second is empty.
STATUS = re.compile(r"(Accepted|Superseded by \d{4}), \d{4}-\d\d-\d\d\.")
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


def undated() -> list[Path]:
    """Return the pages that do not say their status and date."""
    return [
        path
        for path in sorted(FOLDER.glob("*.md"))
        if not STATUS.fullmatch(path.read_text(encoding="utf-8").splitlines()[2])
    ]


def first_commit(path: Path) -> str:
    """Return the date of a page's first commit; today's where there is none yet."""
    log = ["git", "log", "--follow", "--diff-filter=A", "--format=%as", "--", path.name]
    done = subprocess.run(log, cwd=FOLDER, capture_output=True, text=True, check=False)
    return (done.stdout.split() or [datetime.now(tz=UTC).date().isoformat()])[-1]


def main() -> None:
    """Date what is undated."""
    for path in undated():
        title, _, rest = path.read_text(encoding="utf-8").partition("\n")
        text = f"{title}\n\nAccepted, {first_commit(path)}.\n{rest}"
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
