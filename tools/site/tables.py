"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; a bar in a cell is text, not a border.

    >>> print(table(["key", "meaning"], [["`a`", "x | y"]]))
    | key | meaning |
    | --- | --- |
    | `a` | x &#124; y |
    """
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(
        f"| {' | '.join(cell.replace('|', '&#124;').strip() for cell in line)} |" for line in lines
    )


def code(value: object) -> str:
    """Format a value as code; return an empty string if the value is empty."""
    return f"`{value}`" if str(value) else ""
