"""The pages a stranger reads name only what there is."""

import os
import re
from functools import cache
from importlib.metadata import version
from pathlib import Path

import pytest
import yaml

import slipscale
from slipscale import commands
from slipscale.experiments.study.file import shipped_studies
from tools.site import command_reference, gallery, reconstruction_example
from tools.site.hooks import SOURCES

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / ".github/CONTRIBUTING.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
DECISIONS = sorted((ROOT / "docs" / "decisions").glob("*.md"))
# Options of other programs that the pages name.
OF_OTHERS = {"--device-address", "--no-deps", "--places", "--8<--"}


@cache
def generated():
    slow = (reconstruction_example.pages, gallery.pages)  # the test of the site makes their pages
    paths = {path for source in SOURCES if source not in slow for path in source()}
    studies = {f"studies/{name}.{end}" for name in shipped_studies() for end in ("md", "svg")}
    return paths | studies | {"studies/index.md", reconstruction_example.PAGE}


def source(page, target):
    """The path of a link's target among the site's sources."""
    return os.path.relpath(page.parent / target, ROOT / "docs")


def code_in(page):
    """What a page sets as code: the lines of its blocks, and the words between `backticks`."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```.*?\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    prose = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    inline = re.findall(r"`([^`]+)`", prose)
    return [line.strip() for block in blocks for line in block.splitlines()] + [
        " ".join(words.split()) for words in inline
    ]


def parser_of(words):
    """The parser of the command that a line calls: of its subcommand where it has one."""
    known = command_reference.parsers()
    return known.get(" ".join(words[:3])) or known.get(" ".join(words[:2]))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    targets = re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8"))
    # The site has pages that no folder holds; tests/docs/test_site.py follows the links to them.
    missing = [
        target
        for target in targets
        if "://" not in target
        and not (page.parent / target).exists()
        and source(page, target) not in generated()
    ]
    assert missing == []


def wrong_commands(page):
    """The lines that name a command or an option that there is not."""
    anybodys = {
        option
        for parser in command_reference.parsers().values()
        for action in command_reference.arguments(parser)
        for option in action.option_strings
    }
    wrong = []
    for line in code_in(page):
        words = re.sub(r"\s+#.*", "", line).split()
        options = {word.partition("=")[0] for word in words if word.startswith("--")}
        if words[:1] == ["slipscale"] and re.fullmatch("[a-z]+", words[1] if words[1:] else ""):
            parser = parser_of(words)
            known = {
                option
                for action in (command_reference.arguments(parser) if parser else ())
                for option in action.option_strings
            }
            if parser is None or not options <= known:
                wrong.append(line)
        elif line.startswith("--") and not options <= anybodys | OF_OTHERS:
            wrong.append(line)
    return wrong


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_command_and_every_option_named_is_one(page):
    assert wrong_commands(page) == []


def test_a_wrong_command_or_option_in_a_page_is_seen(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("`slipscale study\nshow --seed 3`\n```sh\nslipscale piolt\n```\n`--nope`")
    assert wrong_commands(page) == ["slipscale piolt", "slipscale study show --seed 3", "--nope"]


def test_the_readme_names_every_command():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    unnamed = [name for name in commands.COMMANDS if f"slipscale {name}" not in text]
    assert unnamed == []


def test_the_installed_version_and_the_cited_one_are_those_of_the_front_door():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert version("slipscale") == cited["version"] == slipscale.__version__


def test_a_version_has_a_release_date_once_it_is_released():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.search(r"^## (\S+) \((.+)\)$", changes, re.MULTILINE)
    assert newest
    date = cited.get("date-released", "unreleased")
    assert (newest[1], newest[2]) == (cited["version"], str(date))


@pytest.mark.parametrize("page", DECISIONS, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_decision_names_existing_code(page):
    named = re.findall(r"`([\w/.]+/[\w/.]*)`", page.read_text(encoding="utf-8"))
    assert [path for path in named if "/" in path and not (ROOT / path).exists()] == []
