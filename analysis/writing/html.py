"""Build the report's HTML: tables, figures and sentences.

Jinja or markupsafe escapes all content that comes from data.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from typing import Literal

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from slipscale.faults import UserError

try:
    VERSION = version("slipscale")
except PackageNotFoundError:  # a checkout that is not installed
    VERSION = "unknown"
REPORTING = "slipscale.analysis.reporting"
#: Start tag of a caption -> word that precedes the caption's number.
KINDS = {"<figcaption>": "Figure", "<caption>": "Table"}
#: Tables with at most this many rows stay on one printed page.
ROWS_TOGETHER = 8


@dataclass(slots=True)
class ReportSection:
    """A report section: a heading and the blocks below it."""

    title: str
    blocks: list[Markup] = field(default_factory=list)
    #: State on screen: "always" (cannot be closed), "open" or "closed". In print, all are open.
    shown: Literal["always", "open", "closed"] = "closed"
    #: Sentences that are shown even if the section is closed.
    gist: Sequence[str] = ()

    def __post_init__(self) -> None:
        if isinstance(self.gist, str):  # a text would be a list of letters
            raise UserError(
                "section '{title}': gist is a text, expected a list of sentences", title=self.title
            )

    @property
    def name(self) -> str:
        """HTML anchor of the section, consisting of letters, digits and hyphens."""
        return "-".join(re.findall(r"[a-z0-9]+", self.title.lower()))


@dataclass(frozen=True, slots=True, kw_only=True)
class TableColumn:
    """A table column with its heading, unit and alignment.

    Left-aligned columns contain text, which may wrap unless ``whole`` is True. ``paper`` marks a
    column with values from the paper.
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
    """Return columns with the given headings, or pairs of heading and unit.

    The first ``left`` columns contain text.

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
    """Return a package's Jinja environment, which escapes text and rejects undefined names."""
    return Environment(
        loader=PackageLoader(package),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def page(template: str, package: str = REPORTING, **content: object) -> str:
    """Return a self-contained page, rendered from a package's template."""
    css = files(REPORTING).joinpath("templates", "report.css").read_text(encoding="utf-8")
    ours = {"version": VERSION, "css": Markup(css)}  # noqa: S704 - our own file
    return environment(package).get_template(template).render(ours | content)


def paragraph(text: str, kind: str = "") -> Markup:
    """Return a paragraph; ``kind`` is a class in report.css."""
    attribute = Markup(' class="{}"').format(kind) if kind else Markup()
    return Markup("<p{}>{}</p>").format(attribute, text)


def heading(text: str) -> Markup:
    """Return a subheading."""
    return Markup("<h3>{}</h3>").format(text)


def labelled(label: str, text: str) -> Markup:
    """Return a paragraph that begins with a label in bold."""
    return Markup("<p><b>{}.</b> {}</p>").format(label, text)


def figure_if_drawn(svgs: Mapping[str, str], name: str, caption: str, alt: str) -> list[Markup]:
    """Return a list with the named figure, or an empty list if the figure was not drawn."""
    return [figure(svgs[name], caption, alt)] if name in svgs else []


def details(title: str, blocks: Iterable[Markup]) -> Markup:
    """Return blocks that readers can expand on screen, and that are always expanded in print."""
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
    """Return a bulleted list; ``kind`` is a class in report.css."""
    items = Markup("").join(Markup("<li>{}</li>").format(text) for text in texts)
    return Markup('<ul class="{}">{}</ul>').format(kind, items)


class Figure(Markup):
    """A figure with its caption; the report begins with the first one."""


def figure(svg: str, caption: str, alt: str) -> Figure:
    """Return a figure.

    Parameters
    ----------
    svg : str
        SVG written by Matplotlib.
    caption : str
        Caption as plain text.
    alt : str
        Text alternative for readers who cannot see the figure.
    """
    attributes = Markup('<svg role="img" aria-label="{}"').format(alt)
    picture = Markup(svg.replace("<svg", attributes, 1))  # noqa: S704 - matplotlib escapes
    return Figure("<figure>{}<figcaption>{}</figcaption></figure>").format(picture, caption)


def table(
    columns: Sequence[TableColumn],
    rows: Iterable[Sequence[str]],
    caption: str,
    *,
    over: Sequence[tuple[str, int]] = (),
    marked: int | None = None,
) -> Markup:
    """Return a table.

    A table with more than `ROWS_TOGETHER` rows may break across printed pages and repeats its head.

    Parameters
    ----------
    columns : sequence of TableColumn
        Columns with their headings.
    rows : iterable of sequences of str
        Cell text by row. The first cell of each row is the row heading.
    caption : str
        Caption above the table.
    over : sequence of (str, int)
        Headings above the column headings, each with the number of columns it spans.
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
