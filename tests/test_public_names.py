"""Packages that extend Slipscale need only its public modules."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

PUBLIC = (
    "slipscale",
    "slipscale.protocol",
    "slipscale.backend",
    "slipscale.task",
    "slipscale.question",
)
EXAMPLES = sorted((Path(__file__).parents[1] / "docs" / "extending").rglob("*.py"))


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            yield from ((node.module, each.name) for each in node.names)
        elif isinstance(node, ast.Import):
            yield from ((each.name, None) for each in node.names)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_imports_only_public_names(path):
    ours = [each for each in imported(path) if each[0].split(".")[0] == "slipscale"]
    assert ours
    private = [(m, n) for m, n in ours if m not in PUBLIC or n not in import_module(m).__all__]
    assert private == []
