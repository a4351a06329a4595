"""Every refusal of a table names the way to continue."""

import ast
import re
from pathlib import Path

import pytest

from slipscale.analysis import reading

FOLDER = Path(reading.__path__[0]).resolve()
#: What was expected, an option, or what to do.
WAY = re.compile(
    r"expected|\{(remedy|way)\}|--[a-z]|\b(save|write|convert|remove|export|run|use|select|add|state|rename|set)\b",
    re.IGNORECASE,
)
#: Sentences that another function writes, with their place.
RELAYED = re.compile(r"(line|analysis|[{}:;, ]|\{\w+\})*")


def texts(node):
    """Return the text in an expression, whatever decides between its parts."""
    return " ".join(
        part.value
        for part in ast.walk(node)
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
    )


def refusals():
    for path in [*sorted(FOLDER.rglob("*.py")), FOLDER.parent / "load.py"]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            named = isinstance(node, ast.Call) and getattr(node.func, "id", "")
            if named in ("UserError", "ValueError") and node.args:
                yield pytest.param(texts(node), id=f"{path.name}:{node.lineno}")


FOUND = list(refusals())


@pytest.mark.parametrize("text", FOUND)
def test_every_refusal_names_the_way(text):
    assert WAY.search(text) or RELAYED.fullmatch(text)


def test_the_refusals_are_collected():
    assert len(FOUND) > 60
