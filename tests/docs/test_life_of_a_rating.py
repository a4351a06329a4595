"""Each place that the page names exists; its islands are those that the import rules protect."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "extending" / "life-of-a-rating.md").read_text(encoding="utf-8")
PLACES = sorted(set(re.findall(r"`([\w/]+\.py):([\w.]+)`", TEXT)))


@pytest.mark.parametrize("file, name", PLACES, ids=[":".join(place) for place in PLACES])
def test_a_named_function_or_class_exists(file, name):
    inside = ast.parse((ROOT / file).read_text(encoding="utf-8")).body
    for part in name.split("."):
        found = [each for each in inside if getattr(each, "name", "") == part]
        assert found, f"{file} defines no {name}"
        inside = getattr(found[0], "body", [])


def test_the_page_follows_a_rating_through_all_packages():
    assert len(PLACES) > 20
    assert {file.partition("/")[0] for file, _ in PLACES} == {"experiments", "hardware", "analysis"}


def test_the_islands_of_the_page_are_those_that_nothing_else_may_import():
    config = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = config["tool"]["importlinter"]["contracts"]
    kept = [name for each in contracts for name in each.get("protected_modules", ())]
    table = TEXT.partition("| island | folders |")[2]
    named = {path.removesuffix(".py") for path in re.findall(r"`([\w/]+(?:\.py)?)`", table)}
    assert named == {name.removeprefix("slipscale.").replace(".", "/") for name in kept}
