"""The index of decisions, generated from their titles."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[2] / "docs" / "decisions"
INTRODUCTION = """# Decisions

One page per decision that a future maintainer might question, with its reason. Reasons that concern
a single module are in its docstring.
"""


def pages() -> dict[str, str]:
    """Return the index."""
    titles = {
        path.name: path.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
        for path in sorted(FOLDER.glob("*.md"))
    }
    listed = "\n".join(f"- [{title}]({name})" for name, title in titles.items())
    return {"decisions/index.md": f"{INTRODUCTION}\n{listed}\n"}
