"""Build safe HTML for the report: tables, figures, sentences.

All content from data is escaped, by Jinja or by markupsafe.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from typing import TYPE_CHECKING, Literal

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


try:
    VERSION = version("slipscale")
except PackageNotFoundError:  # a checkout that is not installed
    VERSION = "unknown"
REPORTING = "slipscale.analysis.reporting"
#: Start tag of a caption -> what is counted.
KINDS = {"<figcaption>": "Figure", "<caption>": "Table"}
#: Tables with up to this many rows are not broken across pages.
ROWS_TOGETHER = 8


@dataclass(slots=True)
class ReportSection:
    """A heading and its blocks."""

    title: str
    blocks: list[Markup] = field(default_factory=list)
    #: "always", "open" or "closed" on screen; everything is open in print.
    shown: Literal["always", "open", "closed"] = "closed"
    #: A sentence shown without opening the section.
    gist: str = ""

    @property
    def name(self) -> str:
        """Anchor of the section: letters, digits and hyphens."""
        return "-".join(re.findall(r"[a-z0-9]+", self.title.lower()))


@dataclass(frozen=True, slots=True, kw_only=True)
class TableColumn:
    """A table column: heading, unit, alignment, and whether it shows the paper's values.

    A left-aligned column contains words, which may wrap unless the column is ``whole``.
    """

    title: str
    unit: str = ""
    left: bool = False
    paper: bool = False
    whole: bool = False

    @property
    def classes(self) -> str:
        """CSS classes, separated by spaces."""
        names = (("l", self.left), ("paper", self.paper), ("whole", self.whole))
        return " ".join(name for name, on in names if on)


def columns(*titles: str | tuple[str, str], left: int = 0) -> list[TableColumn]:
    """Return columns with these headings, or headings and units.

    The first ``left`` columns contain words.

    >>> [each.unit for each in columns("Group", ("p", "Holm"), left=1)]
    ['', 'Holm']
    """
    pairs = [(title, "") if isinstance(title, str) else title for title in titles]
    return [
        TableColumn(title=title, unit=unit, left=place < left)
        for place, (title, unit) in enumerate(pairs)
    ]


@cache
def environment(package: str = REPORTING) -> Environment:
    """Return a package's template environment, which escapes text and rejects undefined names."""
    return Environment(
        loader=PackageLoader(package),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def page(template: str, package: str = REPORTING, **content: object) -> str:
    """Return a self-contained page: a package's template, with our styles and version."""
    css = files(REPORTING).joinpath("templates", "report.css").read_text(encoding="utf-8")
    ours = {"version": VERSION, "css": Markup(css)}  # noqa: S704 - our own file
    return environment(package).get_template(template).render(ours | content)


def paragraph(text: str, kind: str = "") -> Markup:
    """Return a paragraph; ``kind`` is a class of report.css."""
    attribute = Markup(' class="{}"').format(kind) if kind else Markup()
    return Markup("<p{}>{}</p>").format(attribute, text)


def heading(text: str) -> Markup:
    """Return a subheading."""
    return Markup("<h3>{}</h3>").format(text)


def labelled(label: str, text: str) -> Markup:
    """Return a paragraph that starts with a label."""
    return Markup("<p><b>{}.</b> {}</p>").format(label, text)


def figure_if_drawn(svgs: Mapping[str, str], name: str, caption: str, alt: str) -> list[Markup]:
    """Return a figure, given its file name; nothing if it was not drawn."""
    return [figure(svgs[name], caption, alt)] if name in svgs else []


def details(title: str, blocks: Iterable[Markup]) -> Markup:
    """Return blocks that a reader can expand; they are expanded in print."""
    return Markup("<details><summary>{}</summary>{}</details>").format(
        title, Markup("").join(blocks)
    )


def numbered(sections: list[ReportSection]) -> list[ReportSection]:
    """Return the sections with numbered figures and tables, in reading order."""
    counts: Counter[str] = Counter()

    def number(match: re.Match[str]) -> str:
        kind = KINDS[match[0]]
        counts[kind] += 1
        return f"{match[0]}<b>{kind} {counts[kind]}.</b> "

    for section in sections:
        section.blocks = [
            Markup(re.sub("|".join(KINDS), number, block))  # noqa: S704 - safe before
            for block in section.blocks
        ]
    return sections


def bullets(texts: Iterable[str], kind: str = "") -> Markup:
    """Return a list; ``kind`` is a class of report.css."""
    items = Markup("").join(Markup("<li>{}</li>").format(text) for text in texts)
    return Markup('<ul class="{}">{}</ul>').format(kind, items)


def figure(svg: str, caption: str, alt: str) -> Markup:
    """Return a figure.

    Parameters
    ----------
    svg : str
        Matplotlib's output.
    caption : str
        Caption as plain text.
    alt : str
        Text alternative for readers who cannot see the figure.
    """
    attributes = Markup('<svg role="img" aria-label="{}"').format(alt)
    picture = Markup(svg.replace("<svg", attributes, 1))  # noqa: S704 - matplotlib escapes
    return Markup("<figure>{}<figcaption>{}</figcaption></figure>").format(picture, caption)


def table(
    columns: Sequence[TableColumn],
    rows: Iterable[Sequence[str]],
    caption: str,
    *,
    over: Sequence[tuple[str, int]] = (),
    marked: int | None = None,
) -> Markup:
    """Return a table.

    A table of more than `ROWS_TOGETHER` rows may break across printed pages, repeating its head.

    Parameters
    ----------
    columns : sequence of TableColumn
        Columns with their headings.
    rows : iterable of sequences of str
        Cells as text; the first cell is the row heading.
    caption : str
        Caption above the table.
    over : sequence of (str, int)
        Headings above the column headings, each with the number of columns that it spans.
    marked : int, optional
        Index of the row to emphasise.
    """
    macro = environment().get_template("table.html").module.table  # type: ignore[attr-defined]
    return Markup(  # noqa: S704 - the template escapes every cell
        macro(
            columns=columns,
            rows=list(rows),
            caption=caption,
            over=over,
            marked=marked,
            rows_together=ROWS_TOGETHER,
        )
    )
