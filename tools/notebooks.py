"""Execute the notebooks of ``docs/``: python -m tools.notebooks [--write].

Cells run in this process, in one namespace and without a kernel. Outputs are stored as a kernel
would store them: printed text, then the value of the last expression as text, HTML and SVG.
"""

from __future__ import annotations

import argparse
import ast
import copy
import json
import re
import sys
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
#: Method that creates the output of each MIME type.
FORMS = {"text/html": "_repr_html_", "image/svg+xml": "_repr_svg_"}
#: Figures are not compared, because they differ between versions of Matplotlib.
PICTURE = re.compile(r"<svg.*?</svg>", re.DOTALL)

Notebook = dict[str, Any]


def read(path: Path) -> Notebook:
    """Read a notebook."""
    found: Notebook = json.loads(path.read_text(encoding="utf-8"))
    return found


def executed(notebook: Notebook, folder: Path) -> Notebook:
    """Execute a notebook in a folder; return it with the cells' outputs."""
    done = copy.deepcopy(notebook)
    names: dict[str, Any] = {"__name__": "__main__"}
    code = [cell for cell in done["cells"] if cell["cell_type"] == "code"]
    with chdir(folder):
        for number, cell in enumerate(code, start=1):
            cell["execution_count"] = number
            cell["outputs"] = outputs("".join(cell["source"]), names, number)
    return done


def outputs(source: str, names: dict[str, Any], number: int) -> list[dict[str, Any]]:
    """Execute a cell; return what it prints and the value of its last expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = StringIO()
    value = None
    with redirect_stdout(printed):
        exec(compile(tree, f"cell {number}", "exec"), names)  # noqa: S102 - our own notebooks
        if last is not None:
            value = eval(compile(ast.unparse(last), f"cell {number}", "eval"), names)  # noqa: S307
    found: list[dict[str, Any]] = []
    if text := printed.getvalue():
        found.append({"output_type": "stream", "name": "stdout", "text": lines(text)})
    if value is not None:
        data = {"text/plain": lines(repr(value))} | {
            form: lines(made)
            for form, method in FORMS.items()
            # Matplotlib's figures define `_repr_html_`, but it returns None.
            if (made := getattr(value, method, lambda: None)()) is not None
        }
        found.append(
            {
                "output_type": "execute_result",
                "execution_count": number,
                "metadata": {},
                "data": data,
            }
        )
    return found


def lines(text: str) -> list[str]:
    """Return a text as a list of lines, as notebooks store it."""
    return text.splitlines(keepends=True)


def shown(notebook: Notebook) -> list[str]:
    """Return the outputs of each code cell for comparison; for figures, only their presence."""
    return [
        PICTURE.sub("<svg/>", json.dumps(["".join(text) for text in texts(cell)]))
        for cell in notebook["cells"]
        if cell["cell_type"] == "code"
    ]


def texts(cell: Notebook) -> list[list[str]]:
    """Return the texts of a cell's outputs, in all their MIME types."""
    return [
        text
        for output in cell["outputs"]
        for text in output.get("data", {"": output.get("text", [])}).values()
    ]


def main() -> int:
    """Compare the stored outputs with new ones, or replace them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="store the outputs")
    write = parser.parse_args().write
    differing = []
    for path in sorted(DOCS.rglob("*.ipynb")):
        stored = read(path)
        with TemporaryDirectory() as folder:
            done = executed(stored, Path(folder))
        if shown(done) != shown(stored):
            differing.append(path.name)
        if write:
            path.write_text(json.dumps(done, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print("outputs differ:" if differing else "outputs are as stored", *differing)
    return 1 if differing and not write else 0


if __name__ == "__main__":
    sys.exit(main())
