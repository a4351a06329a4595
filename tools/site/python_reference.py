"""The Python API reference: one page per package, rendered by mkdocstrings."""

from __future__ import annotations

import ast
from pathlib import Path

from tools.site.tables import table

ROOT = Path(__file__).parents[2]
WINGS = ("analysis", "experiments", "hardware", "stimuli", "figure_style", "faults")
# Commands have a separate reference, and the participant's window is not meant for import.
LEFT_OUT = ("cli", "psychopy_window")
INTRODUCTION = """# Python API

This page is generated from the docstrings of public names, with their units, shapes and errors.
For how they work together, see [the analysis in Python](../../how-to/in-python.md). Other names may
change without notice.
"""


def pages() -> dict[str, str]:
    """Return one page per package, and the index."""
    made = {
        f"reference/python/{package_name(package)}.md": page(package)
        for wing in WINGS
        for package in packages(ROOT / wing)
    }
    rows = [
        [
            f"[{Path(path).stem}]({Path(path).name})",
            summary(ROOT.joinpath("src", *Path(path).stem.split("."))),
        ]
        for path in made
    ]
    index = f"{INTRODUCTION}\n{table(['package', 'what it holds'], rows)}\n"
    return {"reference/python/index.md": index, **made}


def packages(folder: Path) -> list[Path]:
    """Return a package and its subpackages that contain public modules or names."""
    found = [
        path.parent
        for path in sorted(folder.rglob("__init__.py"))
        if not set(path.relative_to(ROOT).parts) & set(LEFT_OUT)
    ]
    return [package for package in found if modules(package) or package.parent == ROOT]


def modules(package: Path) -> list[Path]:
    """Return the public modules of a package."""
    return sorted(path for path in package.glob("*.py") if not path.stem.startswith("_"))


def package_name(folder: Path) -> str:
    """Return the name with which a package is imported."""
    return ".".join(["slipscale", *folder.relative_to(ROOT).parts])


def summary(package: Path) -> str:
    """Return the first line of a package's docstring."""
    tree = ast.parse((package / "__init__.py").read_text(encoding="utf-8"))
    return (ast.get_docstring(tree) or "").partition("\n")[0]


def page(package: Path) -> str:
    """Return a package's page: the package itself if it defines anything, then its modules."""
    name = package_name(package)
    found = modules(package)
    blocks = [f"::: {name}.{path.stem}" for path in found] if found else [f"::: {name}"]
    return f"# {name}\n\n{summary(package)}\n\n" + "\n\n".join(blocks) + "\n"
