"""The pages a stranger reads name only what there is."""

import re
from pathlib import Path

import pytest

import slipscale

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


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


def test_the_version_is_one():
    declared = re.search(r'^version = "(.+)"', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert declared
    assert cited
    assert declared[1] == cited[1] == slipscale.VERSION
