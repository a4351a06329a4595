"""An extension of Griffe that renders doctests, tables and literal blocks in docstrings."""

from __future__ import annotations

import re

import griffe

from tools.site.tables import table

# From a prompt to the next empty line or the docstring's end.
DOCTEST = re.compile(r"^>>> .*(?:\n(?!\s*$).+)*", re.MULTILINE)
# A simple table of reStructuredText, with or without a header.
RULER = r"^=+(?: +=+)+\n"
TABLE = re.compile(f"({RULER})((?:.+\n)+?)(?:{RULER}((?:.+\n)+?))?=+(?: +=+)+$", re.MULTILINE)


class Doctests(griffe.Extension):
    """Write doctests, simple tables and literal blocks as Markdown."""

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        """Rewrite an object's docstring before it is parsed."""
        if obj.docstring:
            text = DOCTEST.sub(r"```pycon\n\g<0>\n```", obj.docstring.value)
            text = re.sub(r"(?<=\S)::$", ":", text, flags=re.MULTILINE)
            obj.docstring.value = TABLE.sub(markdown_table, text)


def markdown_table(found: re.Match[str]) -> str:
    r"""Return a simple table of reStructuredText as a Markdown table.

    A line whose first cell is empty continues the row above it.

    >>> rest = "===  ====\na    b\n===  ====\n`q`  one\n     two\n===  ===="
    >>> print(TABLE.sub(markdown_table, rest))
    | a | b |
    | --- | --- |
    | `q` | one two |
    >>> print(TABLE.sub(markdown_table, "===  ====\n`q`  one\n===  ===="))
    | name | meaning |
    | --- | --- |
    | `q` | one |
    """
    starts = [column.start() for column in re.finditer("=+", found[1])]
    header, body = (found[2], found[3]) if found[3] else ("", found[2])

    def cells(line: str) -> list[str]:
        ends = [*starts[1:], None]
        return [line[start:end].strip() for start, end in zip(starts, ends, strict=True)]

    rows: list[list[str]] = []
    for line in body.splitlines():
        new = cells(line)
        if new[0] or not rows:
            rows.append(new)
        else:
            rows[-1] = [f"{old} {more}".strip() for old, more in zip(rows[-1], new, strict=True)]
    return table(cells(header) if header else ["name", "meaning"], rows)
