"""The pages a stranger reads name only what there is."""

import re
from importlib.metadata import version
from pathlib import Path

import pytest
import yaml

import slipscale

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
DECISIONS = sorted((ROOT / "docs" / "decisions").glob("*.md"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page):
    targets = re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8"))
    missing = [t for t in targets if "://" not in t and not (page.parent / t).exists()]
    assert missing == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_named_is_a_command(page):
    text = page.read_text(encoding="utf-8")
    # In code only: a line of a block, or `slipscale word`.
    named = re.findall(r"(?:^|`)slipscale ([a-z]+)\b", text, flags=re.MULTILINE)
    assert set(named) <= set(slipscale.COMMANDS)


def test_the_readme_names_every_command():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    unnamed = [name for name in slipscale.COMMANDS if f"slipscale {name}" not in text]
    assert unnamed == []


def test_the_installed_version_and_the_cited_one_are_those_of_the_front_door():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert version("slipscale") == cited["version"] == slipscale.VERSION


def test_a_version_has_a_release_date_once_it_is_released():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.search(r"^## (\S+) \((.+)\)$", changes, re.MULTILINE)
    assert newest
    date = cited.get("date-released", "unreleased")
    assert (newest[1], newest[2]) == (cited["version"], str(date))


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: page.name)
def test_a_decision_says_its_number_its_status_and_its_date(page):
    lines = page.read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith(f"# {page.name[:4]}")
    # The form, as its first paragraph: "Accepted, 2026-11-21." or "Superseded by 0120, 2027-01-31."
    assert re.fullmatch(r"(Accepted|Superseded by \d{4}), \d{4}-\d\d-\d\d\.", lines[2])
