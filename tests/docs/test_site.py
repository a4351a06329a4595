"""The documentation site: it builds without a warning, and asks the network for nothing."""

import argparse
import json
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import slipscale
from slipscale.experiments.study.file import read_study, shipped_studies, study_text
from slipscale.experiments.study.schema import study_schema
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.source import Sample, SensorFault, Surroundings
from tests.support.own_modules import FOLDERS
from tools.site import (
    cite,
    command_reference,
    gallery,
    hooks,
    plate_reference,
    python_reference,
    study_reference,
)

ROOT = Path(__file__).parents[2]
PUBLIC_MODULES = ("slipscale.protocol", "slipscale.question", "slipscale.backend", "slipscale.task")
# What a browser fetches by itself, and where the address stands.
FETCHED = {
    ("script", "src"),
    ("img", "src"),
    ("img", "srcset"),
    ("source", "src"),
    ("source", "srcset"),
    ("video", "src"),
    ("audio", "src"),
    ("iframe", "src"),
    ("embed", "src"),
    ("object", "data"),
    ("link", "href"),
}


class Page(HTMLParser):
    """A page's links, and what a browser fetches to show it."""

    def __init__(self, text):
        super().__init__()
        self.links, self.fetched, self.identifiers = [], [], set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if (tag, name) in FETCHED:
                self.fetched.append(value)
            elif (tag, name) == ("a", "href"):
                self.links.append(value)
            elif name == "id":
                self.identifiers.add(value)
            elif name == "style":
                self.fetched += addresses(value)


def addresses(css):
    return [each for each in re.findall(r"url\(['\"]?([^'\")]+)", css) if each[:5] != "data:"]


def is_elsewhere(address):
    return bool(urlsplit(address).netloc) or address.startswith("/")


def build(folder):
    """Build the site.

    The example of a reconstruction uses few data sets, and ruff does not start once per signature
    to break its lines: `make docs` builds all.
    """
    code = "import runpy, sys; sys.modules['ruff'] = None; sys.path[0] = sys.argv.pop(1)\n"
    code += "from tools.site import reconstruction_example as example\n"
    code += "example.SAMPLES = 20\n"
    code += "runpy.run_module('mkdocs', run_name='__main__')"
    words = ("build", "--strict", "--quiet", "--site-dir", str(folder))
    done = subprocess.run(
        [sys.executable, "-c", code, str(ROOT), *words],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


@pytest.fixture(scope="module")
def site(made_once):
    return made_once("site", build)


@pytest.fixture(scope="module")
def pages(site):
    return {path: Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def test_the_python_reference_shows_the_public_modules_and_each_of_their_names(pages, site):
    shown = {path.stem: page for path, page in pages.items() if path.parent.name == "python"}
    assert set(shown) == {*python_reference.PUBLIC, "index"}
    for name in PUBLIC_MODULES:
        wanted = {f"{name}.{each}" for each in import_module(name).__all__}
        assert wanted - shown[name].identifiers == set()


def test_every_page_of_docs_is_built_and_in_the_menu_under_its_folder(pages, site):
    written = [path.relative_to(ROOT / "docs") for path in (ROOT / "docs").rglob("*.md")]
    built = {path.relative_to(site) for path in pages}
    assert {path.with_suffix(".html") for path in written} <= built
    places = {*hooks.MENU, "decisions", "index.md"} - {"studies"}
    assert {str(path.parts[0]) for path in written} == places
    first = list(hooks.MENU["how-to"])
    assert {"How to": [*first, "how-to/new.md"]} in hooks.menu(["how-to/new.md", *first])


def test_no_page_shows_a_fence_of_markdown_or_the_place_of_an_example(site):
    for mark in ("```", "8&lt;"):
        assert [path.name for path in site.rglob("*.html") if mark in path.read_text("utf-8")] == []


def test_the_pages_request_nothing_from_the_network(pages, site):
    assert len(pages) > 50
    outside = {each for page in pages.values() for each in page.fetched if is_elsewhere(each)}
    outside |= {
        each
        for sheet in site.rglob("*.css")
        for each in addresses(sheet.read_text(encoding="utf-8"))
        if is_elsewhere(each)
    }
    assert outside == set()
    # Diagrams, the repository's facts and icons would be fetched by the theme's scripts.
    assert not [path for path in pages if 'class="mermaid"' in path.read_text(encoding="utf-8")]
    assert "repo_url" not in (ROOT / "mkdocs.yml").read_text(encoding="utf-8")


def test_every_link_and_every_file_of_a_page_is_there_without_a_server(pages):
    missing = set()
    for path, page in pages.items():
        for address in [*page.links, *page.fetched]:
            parts = urlsplit(address)
            if parts.scheme:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file() or (
                parts.fragment
                and target in pages
                and parts.fragment not in {*pages[target].identifiers, "__skip"}
            ):
                missing.add((path.name, address))
    assert missing == set()


def test_the_reference_of_the_study_file_has_a_line_for_every_key():
    text = study_reference.pages()["reference/study-file.md"]
    parts = list(study_reference.parts(study_schema()))
    keys = [key for _, part in parts for key in part["properties"]]
    assert len(keys) > 60
    assert [
        len(re.findall(f"^## {re.escape(name)}$", text, re.MULTILINE)) for name, _ in parts
    ] == ([1] * len(parts))
    lines = re.findall(r"^\| `(\w+)` \|(.+)\|(.*)\|(.*)\|(.*)\|$", text, re.MULTILINE)
    assert [line[0] for line in lines] == keys
    assert all(meaning.strip() for _, meaning, *_ in lines)


def test_the_reference_of_commands_says_what_every_argument_means():
    silent = [
        (prog, action.dest)
        for prog, parser in command_reference.parsers().items()
        for action in command_reference.arguments(parser)
        if not action.help or action.help.startswith("default")
    ]
    assert silent == []
    # An option that sets nothing unless it is given has no default.
    assert argparse.SUPPRESS not in "".join(command_reference.pages().values())


def test_the_reference_of_plates_describes_every_shipped_backend():
    (page,) = plate_reference.pages().values()
    shipped = re.findall(
        r"^(\w+) = \"slipscale\.hardware\.backends",
        (ROOT / "pyproject.toml").read_text("utf-8"),
        re.MULTILINE,
    )
    assert re.findall(r"^## (\w+)", page, re.MULTILINE) == sorted(shipped)
    assert "quality factor (60)" in page


def test_a_study_s_page_has_its_source_effect_assumed_values_analysis_and_file():
    page = gallery.page("monnoyer2016", *read_study("monnoyer2016"))
    assert "of which only the abstract was read" in page
    effect = gallery.PUBLISHED["monnoyer2016"]
    assert f"| {' | '.join(effect[each] for each in gallery.EFFECT)} |" in page
    adaptive = gallery.page("bau2010", *read_study("bau2010"))
    assert "in task detectionthreshold: 0 to 120 V peak; frequency: 80 Hz, 180 Hz" in adaptive
    assert '\n  rule = "staircase"\n' in adaptive
    assert " = None" not in adaptive
    assert "analysis of variance" not in adaptive  # thresholds: no estimates to test
    assert "the stimulus: 0.9, 1.15, 1.4 µm peak to peak; initial level: 0.1 µm p-p, 2.2" in page
    assert '| `force = "load_cells:/dev/ttyUSB0"` | replace with your sensor |' in page
    assert "The exponent is the mean of participants' regression slopes" in page
    assert "Each factor was tested together with final amplitude" in page
    assert study_text("monnoyer2016").strip() in page


def test_the_index_of_published_studies_links_to_each_study_s_page(pages, site):
    links = pages[site / "tutorials" / "published-studies.html"].links
    assert {f"../studies/{name}.html" for name in gallery.PUBLISHED} <= set(links)


def test_the_search_ranks_pages_for_users_before_generated_ones(site):
    found = json.loads((site / "search/search_index.json").read_text(encoding="utf-8"))["docs"]
    ranks = {each["location"]: each.get("boost", 1.0) for each in found}
    assert ranks["how-to/finger.html"] == ranks["tutorials/first-day.html"] == 2.0
    assert ranks["extending/adding-a-sensor.html"] == 1.0
    assert ranks["reference/commands.html"] == ranks["studies/biet2007.html"] == 0.6
    assert ranks["decisions/pilots.html"] == ranks["changelog.html"] == 0.3


def test_the_page_on_citing_has_the_version_and_both_entries():
    text = cite.pages()["cite.md"]
    assert f"version {slipscale.__version__}" in text
    assert "@software{slipscale," in text
    assert "  pages = {2678--2688}," in text
    assert "M. Biet, F. Giraud, B. Lemaire-Semail" in text


def test_the_gallery_shows_a_figure_of_each_study():
    index = gallery.pages()["studies/index.md"]
    for name in shipped_studies():
        assert f"]({name}.md)\n\n    ![Level of each trial of participant 01]({name}.svg)" in index


def test_the_page_on_the_environment_lists_each_variable_that_the_package_reads_or_sets():
    page = (ROOT / "docs/reference/environment.md").read_text(encoding="utf-8")
    listed = set(
        re.findall(r"`([A-Z_]+)`", page.partition("## Environment")[2].partition("Proxies")[0])
    )
    own = re.compile(r"environ(?:\.get|\.setdefault)?[\[(]\"(\w+)\"|\"(\w+)\" in os\.environ")
    used = {
        name
        for folder in ("src/slipscale", *FOLDERS)
        for path in (ROOT / folder).rglob("*.py")
        for pair in own.findall(path.read_text(encoding="utf-8"))
        for name in pair
        if name
    }
    assert used | {"SLIPSCALE_MESSAGES_AS_DATA"} == listed


def test_the_sensor_on_its_page_measures_and_reports_its_fault(tmp_path):
    page = (ROOT / "docs/extending/adding-a-sensor.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python file=ourcell.py\n(.*?)```", page, re.DOTALL)
    made = {}
    exec(code, made)  # noqa: S102 - our own page
    file = tmp_path / "cell.txt"
    file.write_text("0.5 -0.25")
    clock = VirtualClock()
    with made["open_force"](str(file), Surroundings(clock=clock)) as source:
        assert source.take() == [Sample(clock.now(), (0.5, -0.25))]
        file.write_text("")
        with pytest.raises(SensorFault, match="ourcell"):
            source.begin()
