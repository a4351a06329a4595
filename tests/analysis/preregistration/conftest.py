"""One small study, frozen and piloted once, for all tests of plans."""

import shutil
from pathlib import Path

import pytest

from slipscale import commands
from slipscale.analysis.preregistration.bundle import write_bundle

STUDY = """
name = "small"
title = "A small study"
amplitudes_um_pp = [0.0, 1.2, 2.3]
participants = 4
seed = 3
sessions = ["01"]
[[tasks]]
protocol = "magnitude_estimation"
scale_top = "declared"
repetitions = 2
[analysis]
normalisation = "scale_top"
tests = ["friedman", "pairwise", "power_law"]
codebook = "words.toml"
"""


@pytest.fixture(scope="session")
def frozen(tmp_path_factory):
    """Return a folder with study.toml, its plan as a folder and as a zip, and a pilot's data."""
    root = tmp_path_factory.mktemp("frozen")
    (root / "small.toml").write_text(STUDY)
    (root / "words.toml").write_text('name = "words"\n[categories]\nslippery = ["slip"]\n')
    study = str(root / "small.toml")
    assert commands.main(["study", "freeze", study, "--out", str(root / "plan")]) == 0
    files = {
        path.relative_to(root / "plan").as_posix(): path.read_bytes()
        for path in (root / "plan").rglob("*.*")
    }
    write_bundle(root / "plan.zip", files)
    assert commands.main(["pilot", study, "--out", str(root / "data")]) == 0
    shutil.copy(root / "words.toml", root / "data" / "words.toml")
    return root


@pytest.fixture
def whole(frozen, tmp_path):
    """Return a copy of all that, to be changed."""
    shutil.copytree(frozen, tmp_path, dirs_exist_ok=True)
    return Path(tmp_path)


@pytest.fixture
def copied(whole):
    """Return a copy without journals, which would report every changed table."""
    shutil.rmtree(whole / "data" / "sourcedata")
    return whole
