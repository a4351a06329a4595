"""The wheel holds what the checkout holds, in one package, and runs without the checkout."""

import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DATA = (".toml", ".csv", ".json", ".html", ".css", ".typed")
WHEEL = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]
FOLDERS = WHEEL["wheel"]["sources"]


def build(kind, source, folder):
    words = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    subprocess.run(words, cwd=source, check=True, capture_output=True)


def members(folder):
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")  # noqa: S202 - our own archive
        return {name for name in archive.namelist() if ".dist-info/" not in name}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    build("wheel", ROOT, folder)
    return folder, members(folder)


def test_every_module_and_every_data_file_is_in_the_wheel_and_in_one_package(wheel):
    wanted = {
        f"{target}/{path.relative_to(ROOT / source).as_posix()}"
        for source, target in FOLDERS.items()
        for path in (ROOT / source).rglob("*")
        if path.suffix in (".py", *DATA) and "__pycache__" not in path.parts
    }
    assert len(wanted) > 500
    assert wanted - wheel[1] == set()
    assert "slipscale/pins/session.txt" in wheel[1]  # what `slipscale setup session` installs
    assert {name.partition("/")[0] for name in wheel[1]} == {"slipscale"}


def test_a_wheel_built_from_the_source_archive_is_the_same(wheel, tmp_path):
    build("sdist", ROOT, tmp_path)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as source:
        assert not [each.name for each in source if each.issym() or each.islnk()]
        # Debian 12's Python 3.11.2 has no filters, and takes no argument for one.
        source.extraction_filter = getattr(tarfile, "data_filter", None)
        source.extractall(tmp_path / "source")  # noqa: S202 - our own archive
    (folder,) = (tmp_path / "source").iterdir()
    build("wheel", folder, tmp_path)
    assert members(tmp_path) == wheel[1]


def test_the_installed_package_runs_without_the_checkout(wheel, tmp_path):
    site = str(wheel[0] / "site")
    code = (
        f"import sys; sys.path.insert(0, {site!r}); from slipscale import commands, experiments; "
        f"assert experiments.__file__.startswith({site!r}); "
        "sys.exit(commands.main(['study', 'validate', 'biet2007']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "no fault" in done.stdout
