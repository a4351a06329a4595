"""What a release publishes beside the package agrees with the package."""

import json
import re
import tomllib
from pathlib import Path

import pytest
import yaml

import slipscale
from tools import setup

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PAPER = (ROOT / "publishing/paper.md").read_text(encoding="utf-8")
RECIPE = yaml.safe_load((ROOT / "publishing/recipe/meta.yaml").read_text(encoding="utf-8"))
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8"))


def test_the_archive_s_metadata_agree_with_the_package_and_the_citation():
    archived = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert archived["version"] == slipscale.__version__
    assert archived["license"] == PROJECT["license"] == cited["license"]
    assert archived["creators"] == PROJECT["authors"] == cited["authors"]
    assert archived["keywords"] == cited["keywords"]
    assert archived["title"] == cited["title"]


def test_the_conda_recipe_has_the_version_requirements_and_command_of_the_package():
    def normal(requirement):
        words = requirement.replace(" ", "").replace("matplotlib-base", "matplotlib")
        return words.replace("{{python_min}}", oldest)

    config = (ROOT / "publishing/recipe/conda_build_config.yaml").read_text(encoding="utf-8")
    (oldest,) = yaml.safe_load(config)["python_min"]
    python = f"python{PROJECT['requires-python']}"
    assert RECIPE["package"] == {"name": "slipscale", "version": slipscale.__version__}
    run = {normal(each) for each in RECIPE["requirements"]["run"]}
    required = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["analysis"]]
    assert run == {normal(each) for each in required} | {python}
    commands = [f"{name} = {target}" for name, target in PROJECT["scripts"].items()]
    assert RECIPE["build"]["entry_points"] == commands
    assert RECIPE["about"]["license"] == f"{PROJECT['license']} AND MIT"  # MIT: the firmware
    assert RECIPE["about"]["license_file"] == PROJECT["license-files"]


@pytest.mark.parametrize("job", ["pilot", "test"])
def test_the_workflow_runs_every_python_that_a_set_supports_on_three_systems(job):
    matrix = WORKFLOW["jobs"][job]["strategy"]["matrix"]
    newest, _size = setup.SETS[job]
    minors = range(setup.OLDEST[1], newest[1] + 1)
    assert matrix["python"] == [f"3.{minor}" for minor in minors]
    assert [system.partition("-")[0] for system in matrix["os"]] == ["ubuntu", "windows", "macos"]


def test_the_pythons_of_the_package_are_those_of_its_largest_range():
    minors = [newest[1] for newest, _size in setup.SETS.values()]
    assert PROJECT["requires-python"] == f">=3.{setup.OLDEST[1]},<3.{max(minors) + 1}"


def test_the_paper_cites_each_reference_and_no_other_and_keeps_the_journal_s_length():
    text = PAPER.split("---", 2)[2]
    references = (ROOT / "publishing/paper.bib").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),", references, re.MULTILINE)
    assert sorted(set(re.findall(r"@(\w+)", text))) == sorted(keys)
    assert 750 <= len(text.split()) <= 1750
