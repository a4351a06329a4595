"""The modules of Slipscale, and what they import."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("analysis", "experiments", "faults", "figure_style", "hardware", "stimuli")


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


def imported_by_name(tree):
    """Yield (line, module) for each call of ``import_module`` with a constant."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            yield from (
                (node.lineno, each.value) for each in node.args if isinstance(each, ast.Constant)
            )
