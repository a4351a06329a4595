"""The report's building blocks: tables, figures, sentences, as safe HTML.

Everything that comes from data goes through markupsafe's escaping; nothing is marked safe but
what is built here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


#: A table of so many rows fits on a page and is not broken across two.
ROWS_TOGETHER = 16


@dataclass(slots=True)
class Section:
    """A heading and what stands under it."""

    title: str
    blocks: list[Markup] = field(default_factory=list)


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column of a table: its heading, unit, alignment, and whether it is the paper's.

    A left-aligned column holds words and may break its lines, unless it is ``whole``.
    """

    title: str
    unit: str = ""
    left: bool = False
    paper: bool = False
    whole: bool = False

    def classes(self) -> str:
        """Return the class attribute, or nothing."""
        names = [
            name
            for name, on in (("l", self.left), ("paper", self.paper), ("whole", self.whole))
            if on
        ]
        return f' class="{" ".join(names)}"' if names else ""


def number(value: Any, decimals: int = 2) -> str:
    """Return a number for reading: fixed decimals, a real minus, a dash where there is none.

    >>> number(-1.5), number(float("nan")), number(1234567, 0), number(None)
    ('−1.50', '–', '1 234 567', '–')
    """
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    # Narrow no-break space between thousands, as ISO 80000 has it.
    return f"{value:,.{decimals}f}".replace(",", " ").replace("-", "−")


def counted(count: int, one: str, many: str) -> str:
    """Return a count with its noun.

    >>> counted(1, "participant", "participants"), counted(0, "trial", "trials")
    ('1 participant', '0 trials')
    """
    return f"{number(count, 0)} {one if count == 1 else many}"


def interval(low: float | None, high: float | None, decimals: int = 2) -> str:
    """Return "[low, high]", or a dash.

    >>> interval(0.4, 0.62)
    '[0.40, 0.62]'
    """
    if low is None or high is None or not (math.isfinite(low) and math.isfinite(high)):
        return "–"
    return f"[{number(low, decimals)}, {number(high, decimals)}]"


def paragraph(text: str, kind: str = "") -> Markup:
    """Return a paragraph; ``kind`` is a class of report.css."""
    attribute = Markup(' class="{}"').format(kind) if kind else Markup()
    return Markup("<p{}>{}</p>").format(attribute, text)


def heading(text: str) -> Markup:
    """Return a heading below the section's."""
    return Markup("<h3>{}</h3>").format(text)


def bullets(texts: Iterable[str], kind: str = "") -> Markup:
    """Return a list; ``kind`` is a class of report.css."""
    items = Markup("").join(Markup("<li>{}</li>").format(text) for text in texts)
    return Markup('<ul class="{}">{}</ul>').format(kind, items)


def figure(svg: str, caption: str, alt: str) -> Markup:
    """Return a figure.

    Parameters
    ----------
    svg : str
        Matplotlib's own output.
    caption : str
        Plain text under the figure.
    alt : str
        What the picture shows, for who does not see it.
    """
    attributes = Markup('<svg role="img" aria-label="{}"').format(alt)
    picture = Markup(svg.replace("<svg", attributes, 1))  # noqa: S704 - analysis.figures.estimates escapes
    return Markup("<figure>{}<figcaption>{}</figcaption></figure>").format(picture, caption)


def table(
    columns: Sequence[Column],
    rows: Iterable[Sequence[Any]],
    caption: str,
    *,
    over: Sequence[tuple[str, int]] = (),
    marked: int | None = None,
) -> Markup:
    """Return a table.

    Parameters
    ----------
    rows : iterable of sequences
        Cells as text; the first is the row's heading.
    over : sequence of (str, int)
        A line of headings over the columns, each with how many it spans.
    marked : int, optional
        The row to set off.

    A table of more than `ROWS_TOGETHER` rows may break across printed pages, under the same head.
    """
    rows = list(rows)
    head = ""
    if over:
        spans = "".join(
            f'<th colspan="{count}" scope="colgroup">{escape(t)}</th>' for t, count in over
        )
        head = f'<tr class="over">{spans}</tr>'
    cells = "".join(
        f'<th scope="col"{c.classes()}>{escape(c.title)}'
        + (f'<br><span class="unit">{escape(c.unit)}</span>' if c.unit else "")
        + "</th>"
        for c in columns
    )
    body = []
    for place, row in enumerate(rows):
        first, *rest = row
        line = f'<th scope="row"{columns[0].classes()}>{escape(first)}</th>' + "".join(
            f"<td{column.classes()}>{escape(cell)}</td>"
            for column, cell in zip(columns[1:], rest, strict=True)
        )
        body.append(f'<tr class="on">{line}</tr>' if place == marked else f"<tr>{line}</tr>")
    kind = ' class="long"' if len(rows) > ROWS_TOGETHER else ""
    return Markup(  # noqa: S704 - every cell is escaped above
        '<div class="wide" role="group" aria-label="Table" tabindex="0">'
        f"<table{kind}><caption>{escape(caption)}</caption>"
        f"<thead>{head}<tr>{cells}</tr></thead><tbody>{''.join(body)}</tbody></table></div>"
    )
