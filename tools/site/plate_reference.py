"""The SPEC reference, generated from the docstrings of the shipped backends."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from importlib.metadata import entry_points
from itertools import takewhile

from slipscale.hardware.registry import BACKENDS
from tools.site.tables import table

INTRODUCTION = """# Plates: SPEC

A SPEC selects the plate that a command uses: `BACKEND` or `BACKEND:ADDRESS`, followed by options.
The address is a port or a resource, and commas separate the options:
`serial:/dev/ttyACM0,attention=9`. `slipscale plate list` lists the installed backends, including
your own, and the ports to which a plate may be connected. The sections below are the documentation
of each shipped backend.
"""


def pages() -> dict[str, str]:
    """Return the page."""
    shipped = sorted(entry_points(group=BACKENDS), key=lambda point: point.name)
    sections = [
        f"## {point.name}\n\n{_markdown(inspect.getdoc(import_module(point.module)) or '')}"
        for point in shipped
        if point.module.startswith("slipscale.hardware.")
    ]
    return {"reference/plates.md": "\n\n".join([INTRODUCTION, *sections]) + "\n"}


def _markdown(docstring: str) -> str:
    r"""Convert the tables, code and links of a docstring to Markdown.

    >>> print(_markdown("See ``a``.\n\n===  ====\n``q``  one\n     two\n===  ===="))
    See `a`.
    <BLANKLINE>
    | option | meaning |
    | --- | --- |
    | `q` | one two |
    """
    lines = iter(docstring.splitlines())
    found: list[str] = []
    for line in lines:
        if re.fullmatch(r"=+ +=+", line):
            rows: list[list[str]] = []
            for entry in takewhile(lambda text: not text.startswith("==="), lines):
                if entry.startswith(" ") and rows:
                    rows[-1][1] += f" {entry.strip()}"
                else:
                    rows.append(entry.split(maxsplit=1))
            found.append(table(["option", "meaning"], rows))
        else:
            found.append(line)
    text = "\n".join(found).replace("``", "`")
    return re.sub(r"docs/([\w-]+/)([\w-]+\.md)", r"[\2](../\1\2)", text)
