"""Notebooks of the documentation: every cell runs, and its outputs are those that are stored."""

import copy

import pytest

from tools import notebooks
from tools.site.notebooks import pages

PATHS = sorted(notebooks.DOCS.rglob("*.ipynb"))


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.name)
def test_every_cell_has_the_outputs_that_are_stored(path, tmp_path):
    # To store new ones: python -m tools.notebooks --write
    stored = notebooks.read(path)
    assert notebooks.shown(notebooks.executed(stored, tmp_path)) == notebooks.shown(stored)


def test_another_output_is_seen_and_another_drawing_of_a_figure_is_not():
    cell = {"cell_type": "code", "source": ["print(1)\n", "2"], "outputs": []}
    done = {"cells": [cell | {"outputs": notebooks.outputs("print(1)\n2", {}, 1)}]}
    other = copy.deepcopy(done)
    other["cells"][0]["outputs"][1]["data"]["text/plain"] = ["3"]
    assert notebooks.shown(done) != notebooks.shown(other)
    drawn = [
        {"cells": [cell | {"outputs": [{"data": {"image/svg+xml": [f"<svg>{line}</svg>"]}}]}]}
        for line in "ab"
    ]
    assert notebooks.shown(drawn[0]) == notebooks.shown(drawn[1])


def test_the_site_shows_table_3_and_the_figure_of_the_notebook():
    page = pages()["how-to/in-python.md"]
    assert "```python\nimport slipscale\n" in page
    assert page.count("<svg") == 2
    assert "12.75</td>" in page
