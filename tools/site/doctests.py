"""An extension of Griffe that renders doctests anywhere in docstrings as code."""

from __future__ import annotations

import re

import griffe

# From a prompt to the next empty line or the docstring's end.
DOCTEST = re.compile(r"^>>> .*(?:\n(?!\s*$).+)*", re.MULTILINE)


class Doctests(griffe.Extension):
    """Fence each doctest; otherwise Markdown renders its prompts as quotations."""

    def on_object(self, *, obj: griffe.Object, **_: object) -> None:
        """Rewrite an object's docstring before it is parsed."""
        if obj.docstring:
            obj.docstring.value = DOCTEST.sub(r"```pycon\n\g<0>\n```", obj.docstring.value)
