"""Write a campaign's results into docs/validation/measured/campaigns.md between two markers."""

from __future__ import annotations

from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "validation" / "measured" / "campaigns.md"
END = "<!-- end of figures -->\n"


def put(command: str, text: str) -> None:
    """Replace the results of a command on the page."""
    page = PAGE.read_text(encoding="utf-8")
    begin = f"<!-- figures: {command} -->\n"
    before, mark, rest = page.partition(begin)
    _, end, after = rest.partition(END)
    if not (mark and end):
        raise LookupError(f"{PAGE}: no markers around the results of {command}")
    PAGE.write_text(f"{before}{begin}{text}{END}{after}", encoding="utf-8")
