import re
from pathlib import Path

import pytest

from slipscale.hardware.plate.design import requirements

DOCS = Path(__file__).parents[3] / "docs" / "explanation"


def blocks(name, language):
    text = (DOCS / name).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("name", ["squeeze-film.md", "plate-models.md"])
def test_python_in_the_docs_runs(name):
    shared = {"__name__": "docs"}
    found = blocks(name, "python")
    assert found
    for code in found:
        exec(compile(code, name, "exec"), shared)  # noqa: S102 - our own documentation


def test_brief_in_the_docs_is_a_valid_one(tmp_path):
    (text,) = blocks("plate-models.md", "toml")
    path = tmp_path / "brief.toml"
    path.write_text(text, encoding="utf-8")
    assert requirements.read(path).requirements.workspace_mm == (70, 50)
