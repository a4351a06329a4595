"""An import inside a function has one of three reasons."""

import ast
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("analysis", "experiments", "faults", "figure_style", "hardware", "stimuli")
# 1. Packages that take long to import, are optional, or exist on some systems only.
HEAVY = {
    *("difflib", "distributed", "docx", "jax", "jinja2", "joblib", "lxml", "matplotlib", "nidaqmx"),
    *("numpy", "numpyro", "openpyxl", "pandas", "pingouin", "psychopy", "psychtoolbox", "pydantic"),
    *("pyglet", "pylsl", "pyreadstat", "pyvisa", "rich", "scipy", "serial", "skfem", "sklearn"),
    *("sounddevice", "starlette", "statsmodels", "tomlkit", "uvicorn", "weasyprint"),
    *("msvcrt", "select", "termios", "tty"),
}
# 2. Commands and the lazy API, which import what they run.
COMMANDS = ("slipscale", "slipscale.commands", "slipscale.requirements", "slipscale.analysis.api")


def name_of(path):
    parts = path.with_suffix("").parts
    return ".".join(["slipscale", *(parts[:-1] if parts[-1] == "__init__" else parts)])


def modules():
    """Return the tree of each module, keyed by its name."""
    found = {}
    for folder, places in (("src/slipscale", ("",)), ("", FOLDERS)):
        for place in places:
            base = ROOT / folder
            paths = base.glob("*.py") if folder else (base / place).rglob("*.py")
            for path in paths:
                if "scripts" not in path.parts:
                    tree = ast.parse(path.read_text(encoding="utf-8"))
                    name = name_of(path.relative_to(base))
                    found[name.removesuffix(".__init__")] = tree
    return found


MODULES = modules()


def imported(body, *, inside=False):
    """Yield (inside a function, line, module) for each import that runs."""
    for node in body:
        if isinstance(node, ast.Import):
            yield from ((inside, node.lineno, each.name) for each in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{each.name}" for each in node.names]
            for name in names:
                yield inside, node.lineno, name if name in MODULES else node.module
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from imported(node.orelse, inside=inside)
        else:
            within = inside or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            for part in ("body", "orelse", "finalbody", "handlers"):
                yield from imported(getattr(node, part, ()), inside=within)


@cache
def reached(module):
    """Return the modules that an import of a module imports at once, directly or not."""
    found, new = set(), {module}
    while new:
        found |= new
        trees = (MODULES[each] for each in new if each in MODULES)
        new = {name for tree in trees for within, _, name in imported(tree.body) if not within}
        new -= found
    return found


def has_a_reason(module, name):
    if module in COMMANDS or ".cli." in module:
        return True
    # 3. Modules that import such a package.
    return any(each.partition(".")[0] in HEAVY for each in reached(name))


@pytest.mark.parametrize("folder", ["slipscale", *(f"slipscale.{each}" for each in FOLDERS)])
def test_an_import_inside_a_function_has_a_reason(folder):
    ours = {name: tree for name, tree in MODULES.items() if name.startswith(folder)}
    assert ours
    without = [
        (module, line, name)
        for module, tree in ours.items()
        for within, line, name in imported(tree.body)
        if within and not has_a_reason(module, name)
    ]
    assert without == []
