"""Convert the report to a Word document."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

#: Figure width in cm, which fits the text width of an A4 page (16 cm).
FIGURE_CM = 13.0
#: Tables with more columns than this use a smaller font.
WIDE = 7
#: Fixed date, so that the same report always gives the same file.
DATE = (1980, 1, 1, 0, 0, 0)


def write_word(report: Path, out: Path) -> None:
    """Write a report as ``.docx``.

    Parameters
    ----------
    report : Path
        ``report.html``, with the figures as ``.png`` files next to it.
    out : Path
        Output file.
    """
    from docx import Document
    from lxml import html

    page = html.fromstring(report.read_text(encoding="utf-8"))
    document = Document()
    normal = document.styles["Normal"]
    normal.font.name, normal.font.size = "Arial", _points(10)
    for element in page.iter():
        if isinstance(element.tag, str) and (write := WRITERS.get(element.tag)):
            write(document, element, report.parent)
    stream = io.BytesIO()
    document.save(stream)
    out.write_bytes(_dated(stream))


def _points(size: float) -> Any:
    from docx.shared import Pt

    return Pt(size)


def _text(element: Any) -> str:
    return " ".join(element.text_content().split())


def _heading(level: int) -> Callable[[Any, Any, Path], None]:
    def write(document: Any, element: Any, _folder: Path) -> None:
        document.add_heading(_text(element), level)

    return write


def _paragraph(document: Any, element: Any, _folder: Path) -> None:
    if element.get("class") != "kicker":
        document.add_paragraph(_text(element))


def _item(document: Any, element: Any, _folder: Path) -> None:
    # Word generates the table of contents from the headings.
    if not any(parent.tag == "nav" for parent in element.iterancestors()):
        document.add_paragraph(_text(element), style="List Bullet")


def _fact(document: Any, element: Any, _folder: Path) -> None:
    name, value = element
    document.add_paragraph(f"{_text(name)}: {_text(value)}")


def _figure(document: Any, element: Any, folder: Path) -> None:
    from docx.shared import Cm

    (picture,) = element.xpath("./*[local-name()='svg']")
    (caption,) = element.findall("figcaption")
    document.add_picture(str(folder / f"{picture.get('id')}.png"), width=Cm(FIGURE_CM))
    # Text for screen readers.
    document.inline_shapes[-1]._inline.docPr.set("descr", picture.get("aria-label"))  # noqa: SLF001 - python-docx has no call for it
    document.add_paragraph(_text(caption), style="Caption")


def _table(document: Any, element: Any, _folder: Path) -> None:
    (caption,) = element.findall("caption")
    document.add_paragraph(_text(caption), style="Caption").paragraph_format.keep_with_next = True
    rows = [list(row) for row in element.iter("tr")]
    width = max(sum(int(cell.get("colspan", 1)) for cell in row) for row in rows)
    table = document.add_table(len(rows), width, style="Light List Accent 1")
    for place, row in enumerate(rows):
        column = 0
        for cell in row:
            span = int(cell.get("colspan", 1))
            first, last = table.cell(place, column), table.cell(place, column + span - 1)
            written = (first.merge(last) if span > 1 else first).paragraphs[0]
            # In a table heading, a line break precedes the unit.
            run = written.add_run(" ".join(" ".join(cell.itertext()).split()))
            run.font.size = _points(7 if width > WIDE else 9)
            column += span
    document.add_paragraph()


#: Functions that write HTML elements, keyed by tag. Of other elements, only the content is written.
WRITERS: dict[str, Callable[[Any, Any, Path], None]] = {
    "h1": _heading(0),
    "h2": _heading(1),
    "h3": _heading(2),
    "p": _paragraph,
    "li": _item,
    "div": lambda document, element, folder: (
        _fact(document, element, folder) if element.getparent().tag == "dl" else None
    ),
    "figure": _figure,
    "table": _table,
}


def _dated(stream: io.BytesIO) -> bytes:
    """Return the Word file with the same date for all its parts."""
    out = io.BytesIO()
    with zipfile.ZipFile(stream) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(zipfile.ZipInfo(name, DATE), old.read(name), zipfile.ZIP_DEFLATED)
    return out.getvalue()
