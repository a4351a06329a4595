"""An extension of Griffe: doctests in docstrings are shown as code, wherever they stand."""

from __future__ import annotations

import re

import griffe

# From a prompt to the next empty line or the docstring's end.
DOCTEST = re.compile(r"^>>> .*(?:\n(?!\s*$).+)*", re.MULTILINE)


class Doctests(griffe.Extension):
    """Fence each doctest: Markdown takes its prompts for quotations."""

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        """Rewrite the docstring of an object, before it is parsed."""
        if obj.docstring:
            obj.docstring.value = DOCTEST.sub(r"```pycon\n\g<0>\n```", obj.docstring.value)
