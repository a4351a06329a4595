"""The shape of the repository."""

import subprocess
from collections import defaultdict
from pathlib import Path, PurePosixPath

import pytest

ROOT = Path(__file__).parents[2]
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
