"""An import inside a function has one of three reasons."""

from functools import cache

import pytest

from tests.support.own_modules import FOLDERS, MODULES, imported

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
