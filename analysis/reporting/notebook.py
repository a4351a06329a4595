"""Display an analysis at a Python prompt or in a notebook."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from slipscale import figure_style
from slipscale.analysis.reporting.files import draw, write_analysis
from slipscale.analysis.reporting.page import conclusions
from slipscale.analysis.reporting.tables import tables
from slipscale.analysis.tasks.kind import Analysis
from slipscale.faults import UserError
from slipscale.figure_style.paper import drawn_for, paper_style

#: No colours are set, so that light and dark themes both work. Figures have a white background.
PAGE = Markup(
    '<div style="max-width: 46rem; line-height: 1.5">{heading}{sentences}{table}{figure}</div>'
)
HEADING = Markup('<p style="margin: 0 0 .4rem"><b>{}</b><br>{}</p>')
SENTENCE = Markup('<p style="margin: .4rem 0"><b>{}.</b> {}</p>')
TABLE = Markup(
    '<table style="border-collapse: collapse; font-size: inherit; margin: .6rem 0">{}{}</table>'
)
#: Headings of Table III, keyed by column; the level column is added separately.
HEADS = {
    "n": "n",
    "mean": "mean",
    "maximum_deviation": "maximum deviation",
    "standard_deviation": "SD",
}
FIGURE = Markup(
    '<div style="background: #fff; border-radius: 4px; margin-top: .6rem; padding: .3rem; '
    'max-width: 34rem">{}</div>'
)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class DisplayedAnalysis(Analysis):
    """An analysis that Python and notebooks display as a summary."""

    @property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The result tables, as in the CSV files, keyed by name."""
        return tables(self)

    def plot(
        self, name: str | None = None, *, width: str | None = None, style: str | None = None
    ) -> Figure:
        """Return a figure, by default the first one.

        Parameters
        ----------
        name : str, optional
        width, style : str, optional
            Width such as ``"8.9cm"``, and style ``"ieee"`` or ``"apa"``, of a figure for a paper.
            To save such a figure, use `save`, which keeps its text as text.

        Raises
        ------
        UserError
            If there is no figure with this name, or no such width or style.
        """
        with drawn_for(paper_style(width, style)):
            figures = draw(self)
        if name is None and figures:
            return next(iter(figures.values()))
        if name not in figures:
            raise UserError(
                "plot: no figure '{name}'; expected one of {known}",
                name=name,
                known=", ".join(figures) or "none, because no results can be drawn",
            )
        return figures[name]

    def save(
        self,
        folder: str | Path,
        formats: Collection[str] = (),
        *,
        width: str | None = None,
        style: str | None = None,
    ) -> Path:
        """Write tables, figures and the report into a folder, and return the report's path.

        Parameters
        ----------
        formats : collection of str
            Figure formats in addition to SVG: ``"png"``, ``"pdf"``.
        width, style : str, optional
            Also write figures for a paper, in the folder ``figures``; see `plot`.
        """
        paper = paper_style(width, style)
        return write_analysis(self, Path(folder), formats=formats, paper=paper)

    def __repr__(self) -> str:
        """Summarise the analysis in a few lines of text."""
        first = [f"{title}: {sentences[0]}" for title, sentences in conclusions(self).items()]
        return "\n".join([f"Analysis of {self.dataset.name}", _subject(self), *first])

    def _repr_html_(self) -> str:
        """Return each section's first sentence, Table III and the first figure as HTML."""
        sentences = (
            SENTENCE.format(title, sentences[0]) for title, sentences in conclusions(self).items()
        )
        table = figure = ""
        if self.prepared is not None:
            quantity = self.dataset.quantity
            heads = (quantity.headed(quantity.name), *HEADS.values())
            rows = (
                (
                    f"{amplitude:g}",
                    str(n),
                    *(f"{value:.2f}".replace("nan", "–") for value in values),
                )
                for amplitude, n, *values in self.table3.itertuples(index=False)
            )
            table = TABLE.format(
                _row("th", heads), Markup("").join(_row("td", row) for row in rows)
            )
        if drawn := draw(self):
            name, first = next(iter(drawn.items()))
            svg = figure_style.svg(first, salt=f"notebook_{name}").replace(
                "<svg", '<svg style="max-width: 100%; height: auto"', 1
            )
            figure = FIGURE.format(Markup(svg))  # noqa: S704 - matplotlib escapes
        return str(
            PAGE.format(
                heading=HEADING.format(self.dataset.name, _subject(self)),
                sentences=Markup("").join(sentences),
                table=table,
                figure=figure,
            )
        )


def _row(kind: str, cells: Iterable[str]) -> Markup:
    """Return a table row; ``kind`` is the HTML tag of its cells."""
    cell = Markup(f'<{kind} style="text-align: right; padding: .15rem .6rem">{{}}</{kind}>')  # noqa: S704 - no text
    return Markup("<tr>{}</tr>").format(Markup("").join(map(cell.format, cells)))


def _subject(analysis: Analysis) -> str:
    data = analysis.dataset
    trials = sum(len(rows) for name, rows in data.tables.items() if name != "answers")
    parts = [f"{len(data.people)} participants", f"{trials} trials"]
    if data.mode == "pilot":
        parts[0] = f"{len(data.people)} simulated participants"
    if analysis.prepared is not None:
        parts.append(f"normalised by {analysis.rule}")
    if analysis.problems:
        parts.append(f"{len(analysis.problems)} notes (.problems)")
    return ", ".join(parts)
