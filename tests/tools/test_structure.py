"""The shape of the repository."""

import subprocess
from collections import defaultdict
from graphlib import TopologicalSorter
from pathlib import PurePosixPath

import pytest

from tests.support.own_modules import MODULES, ROOT, imported, imported_by_name

AT_MOST = 20
# Folders that contain one file or folder per thing, as CONTRIBUTING promises: they may grow.
LISTS = {
    "analysis/tasks",
    "analysis/tasks/effects",
    "docs/decisions",
    "experiments/protocols",
    "experiments/studies",
    "hardware/backends",
}


@pytest.fixture(scope="module")
def children():
    """Folder -> the names that git tracks in it; names with a dot only below the root."""
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    found = defaultdict(set)
    for name in filter(None, listed.stdout.split("\0")):
        path = PurePosixPath(name)
        for inner, folder in zip((path, *path.parents), path.parents, strict=False):
            if str(folder) != "." or not inner.name.startswith("."):
                found[str(folder)].add(inner.name)
    return found


def test_a_folder_has_at_most_20_children(children):
    assert len(children) > 100
    assert set(children) >= LISTS
    too_many = {
        name: len(names)
        for name, names in children.items()
        if len(names) > AT_MOST and name not in LISTS
    }
    assert too_many == {}


def test_no_modules_import_one_another_in_a_circle():
    # Imports inside functions and by name count: they only hide a circle.
    imports = {
        module: {
            *(name for _, _, name in imported(tree.body)),
            *(name for _, name in imported_by_name(tree)),
        }
        for module, tree in MODULES.items()
    }
    assert len(imports) > 700
    # The package itself imports what its lazy functions are asked for.
    ours = {each: (names & MODULES.keys()) - {each, "slipscale"} for each, names in imports.items()}
    TopologicalSorter(ours).prepare()  # raises CycleError, which names a circle


def test_no_module_imports_one_of_ours_by_name():
    found = [
        (module, *each)
        for module, tree in MODULES.items()
        for each in imported_by_name(tree)
        if str(each[1]).startswith("slipscale")
    ]
    assert found == []
