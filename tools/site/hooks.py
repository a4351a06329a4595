"""MkDocs hooks: generated pages, their place in the menu, and small corrections.

Pages derived from the code, or from files outside ``docs/``, are generated at build time and not
committed: the references, the gallery of studies, the index of decisions, and the pages at the
repository's root.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mkdocs.structure.files import File, Files

from tools.site import (
    cite,
    command_reference,
    data_set_reference,
    decisions,
    gallery,
    notebooks,
    paper_page,
    plate_reference,
    python_reference,
    reconstruction_example,
    study_reference,
)

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[2]

# Each function returns pages (or other files) by path in the site's sources.
SOURCES: tuple[Callable[[], dict[str, str]], ...] = (
    cite.pages,
    command_reference.pages,
    data_set_reference.pages,
    decisions.pages,
    gallery.pages,
    notebooks.pages,
    paper_page.pages,
    plate_reference.pages,
    python_reference.pages,
    reconstruction_example.pages,
    study_reference.pages,
)
# Path in the site of each page from outside docs/.
AT_THE_ROOT = {
    ".github/CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
# The menu: folders of docs/, each with the pages that come first; others follow by name.
MENU: dict[str, tuple[str, ...]] = {
    "tutorials": ("tutorials/first-day.md",),
    "how-to": ("how-to/install.md", "how-to/run-a-session.md", "how-to/laboratory-folder.md"),
    "studies": ("studies/index.md",),
    "explanation": (),
    "validation": ("validation/index.md", "validation/the-paper.md"),
    "reference": ("reference/study-file.md", "reference/commands.md", "reference/plates.md"),
    "extending": (),
}
PROJECT = ("cite.md", "changelog.md", "contributing.md", "decisions/index.md")
# Placeholder for the generated table of published studies.
PUBLISHED_STUDIES = "<!-- published studies -->"
# Pages that are not in their folder's menu.
SPECIAL = ("decisions/", "reference/python/")
# Rank in the search by the beginning of a page's path: pages for users come first.
RANKS = {
    **dict.fromkeys((*SPECIAL, "changelog.md", "contributing.md"), 0.3),
    **dict.fromkeys(("validation/", "reference/", "studies/"), 0.6),
    **dict.fromkeys(("how-to/", "tutorials/"), 2.0),
}


def rank(path: str) -> float:
    """Return the rank of a page, by the first entry of `RANKS` that matches."""
    return next((value for start, value in RANKS.items() if path.startswith(start)), 1.0)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages, then build the menu from all pages."""
    made = {path: text for source in SOURCES for path, text in source().items()}
    for name, path in AT_THE_ROOT.items():
        made[path] = for_the_site((ROOT / name).read_text(encoding="utf-8"))
    for path, text in made.items():
        files.append(File.generated(config, path, content=text))
    config.nav = menu([file.src_uri for file in files.documentation_pages()])
    return files


def menu(pages: list[str]) -> list[str | dict[str, list[str]]]:
    """Return the menu: each folder of `MENU` with all its pages."""
    found: dict[str, list[str]] = {}
    for folder, first in MENU.items():
        inside = sorted(
            page
            for page in pages
            if page.startswith(f"{folder}/") and not page.startswith(SPECIAL) and page not in first
        )
        found[folder.replace("-", " ").capitalize()] = [*first, *inside]
    found["Reference"].append("reference/python/index.md")
    found["Project"] = list(PROJECT)
    return ["index.md", *({title: entries} for title, entries in found.items())]


def on_post_build(config: MkDocsConfig) -> None:
    """Remove 404.html, because its links begin at the root of a server."""
    Path(config.site_dir, "404.html").unlink(missing_ok=True)


def for_the_site(text: str) -> str:
    """Return a page from the repository's root with links adapted to the site.

    >>> for_the_site("[a](docs/a.md), [b](docs/decisions), [c](hardware/firmware/x)")
    '[a](a.md), [b](decisions/index.md), c'
    """
    for name, path in AT_THE_ROOT.items():
        text = text.replace(f"]({name})", f"]({path})")
    text = text.replace("](../", "](").replace("](docs/decisions)", "](decisions/index.md)")
    text = text.replace("](docs/", "](").replace(".ipynb)", ".md)")
    # Links to files outside the site become plain text.
    text = re.sub(r"(?<!!)\[([^\]]+)\]\((?!https?:)[^)]*(?<!\.md)\)", r"\1", text)
    return text.replace("<details>", '<details markdown="1">')


def on_page_markdown(markdown: str, *, page: Page, **_: object) -> str:
    """Show the file names of code blocks, mark doctests as code, and set the search rank."""
    page.meta["search"] = {"boost": rank(page.file.src_uri)}
    markdown = markdown.replace(".ipynb)", ".md)")
    if PUBLISHED_STUDIES in markdown:
        markdown = markdown.replace(PUBLISHED_STUDIES, gallery.published_studies())
    # "output" marks text that the tests compare; Markdown rejects a fence with two words.
    markdown = re.sub(r"^```(\w+) output$", r"```\1", markdown, flags=re.MULTILINE)
    markdown = re.sub(r"^```(\w+) file=(\S+)$", r'```\1 title="\2"', markdown, flags=re.MULTILINE)
    return markdown.replace("```python\n>>> ", "```pycon\n>>> ")
