"""Write the results of many simulated studies to files: a page, figures, CSV and JSON."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure

from slipscale.analysis import json_form
from slipscale.analysis.planning.distribution.distribution import Distribution
from slipscale.analysis.planning.distribution.figures import (
    CURVES,
    PANELS,
    STATISTICS,
    cells_figure,
    curves_figure,
    results_figure,
)
from slipscale.analysis.planning.distribution.numbers import ResultName
from slipscale.analysis.planning.distribution.terminal import percent, sentences, values
from slipscale.analysis.writing import html
from slipscale.analysis.writing.csv_file import write_csv
from slipscale.faults import UserError
from slipscale.figure_style import save, svg
from slipscale.stimuli.level_names import path_in_file
from slipscale.stimuli.quantity import Quantity

PAGE = "distribution.html"


def claim(folder: Path) -> None:
    """Check that a folder is new, or contains the output of an earlier simulation.

    Raises
    ------
    UserError
        If the folder contains other files. These files are left unchanged.
    """
    try:
        if folder.exists() and any(folder.iterdir()) and not (folder / PAGE).exists():
            raise UserError(
                "--out {folder}: the folder is not empty; expected a new folder, or a folder "
                "with an earlier {page}",
                folder=folder,
                page=PAGE,
            )
    except OSError as error:
        raise UserError("--out {folder}: {reason}", folder=folder, reason=error.strerror) from None


def write_distribution(folder: Path, found: Distribution) -> Path:
    """Write ``distribution.html``, tables, JSON and figures; return the page.

    Raises
    ------
    UserError
        If the folder cannot be written.
    """
    figures: dict[str, Figure] = {}
    if found.levels:
        figures |= {"table3": cells_figure(found), "fig15": curves_figure(found)}
    if found.headlines:
        figures["results"] = results_figure(found)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, table in _tables(found).items():
            write_csv(table, folder / f"{name}.csv")
        (folder / "distribution.json").write_text(json_form.text(_record(found)), encoding="utf-8")
        for name, figure in figures.items():
            save(figure, folder / name, (".svg", ".png"))
        page = folder / PAGE
        page.write_text(_page(found, figures), encoding="utf-8")
    except OSError as error:
        raise UserError(
            "{file}: {reason}", file=error.filename or folder, reason=error.strerror
        ) from None
    return page


def _tables(found: Distribution) -> dict[str, pd.DataFrame]:
    """Return tables of spreads, proportions and all studies' results, keyed by file name."""
    named = partial(_in_file, found.quantity)
    return {
        "numbers": pd.DataFrame(
            [(named(s.name), s.studies, s.median, s.p5, s.p95) for s in found.numbers],
            columns=["number", "studies", "median", "p5", "p95"],
        ),
        "conclusions": pd.DataFrame(
            [
                (named(c.name), c.words, c.share.value, c.share.low, c.share.high, c.share.studies)
                for c in found.conclusions
            ],
            columns=["conclusion", "words", "share", "low", "high", "studies"],
        ),
        "studies": pd.DataFrame(
            [
                {"study": e.number, "seed": e.seed, "refused": e.refused}
                | {named(name): value for name, value in e.found.numbers.items()}
                for e in found.results
            ]
        ),
    }


def _in_file(quantity: Quantity, name: ResultName) -> str:
    return path_in_file(str(name), quantity.in_file)


def _record(found: Distribution) -> dict[str, object]:
    """Return the content of distribution.json."""
    named = partial(_in_file, found.quantity)
    return {
        "study": found.study,
        "participants": found.participants,
        "population": found.population,
        "seed": found.seed,
        "studies": len(found.results),
        "full_sessions": bool(found.sessions),
        "refused": found.refused,
        "numbers": {
            named(s.name): {"studies": s.studies, "median": s.median, "p5": s.p5, "p95": s.p95}
            for s in found.numbers
        },
        "conclusions": {
            named(c.name): {"words": c.words, "share": c.share.value, "low": c.share.low,
                     "high": c.share.high}
            for c in found.conclusions
        },
    }  # fmt: skip


def _page(found: Distribution, figures: dict[str, Figure]) -> str:
    return html.page(
        "distribution.html",
        "slipscale.analysis.planning",
        title=f"{found.title}, simulated {len(found.results)} times",
        sentences=sentences(found),
        sections=html.numbered(_sections(found, figures)),
    )


def _sections(found: Distribution, figures: dict[str, Figure]) -> list[html.ReportSection]:
    table = html.ReportSection("The table of results")
    if "table3" in figures:
        table.blocks += [
            html.figure(
                svg(figures["table3"], salt="table3"),
                "Median and 5th and 95th percentiles across studies for each cell of Table III. "
                "Diamonds are the published values.",
                "Medians and percentiles of means, maximum deviations and standard deviations",
            ),
            _cells(found),
            html.figure(
                svg(figures["fig15"], salt="fig15"),
                f"Mean estimates as a function of {found.quantity.level}. Thin lines: up to "
                f"{CURVES} single studies; thick line: median; band: 5th to 95th percentile of "
                "all studies.",
                f"One curve per study: mean estimates that rise with {found.quantity.level}",
            ),
        ]
    other = html.ReportSection("Other results")
    if "results" in figures:
        other.blocks.append(
            html.figure(
                svg(figures["results"], salt="results"),
                f"Number of studies with each value, for the first {PANELS} results at most. "
                "Line: median; band: 5th to 95th percentile of the studies.",
                "Histograms of results across studies",
            )
        )
        other.blocks.append(_spreads([(w, *values(s)) for s, w in found.headlines], "Main"))
    rows = [(_in_file(found.quantity, s.name), *values(s)) for s in found.numbers if s.varies]
    other.blocks.append(html.details(f"All {len(rows)} numbers", [_spreads(rows, "All")]))
    return [s for s in (table, _conclusions(found), other) if s.blocks]


def _cells(found: Distribution) -> Markup:
    columns = html.columns(
        (found.quantity.title, found.quantity.unit_in_short),
        *((title, "median (5 to 95 %)") for title in STATISTICS.values()),
    )
    rows = []
    for amplitude in found.levels:
        cells = [found.cell(amplitude, statistic) for statistic in STATISTICS]
        rows.append([f"{amplitude:g}", *(_range(*values(cell)) if cell else "–" for cell in cells)])
    return html.table(columns, rows, "Table III across the simulated studies.")


def _range(studies: str, median: str, p5: str, p95: str) -> str:  # noqa: ARG001 - as in the tables
    return f"{median} ({p5} to {p95})"


def _spreads(rows: Sequence[tuple[str, ...]], which: str) -> Markup:
    columns = html.columns("Number", "Studies", "Median", "5 %", "95 %", left=1)
    return html.table(columns, rows, f"{which} results across the simulated studies.")


def _conclusions(found: Distribution) -> html.ReportSection:
    section = html.ReportSection("How often each conclusion holds")
    if not found.conclusions:
        return section
    rows = [
        [c.words, percent(c.share.value), f"{percent(c.share.low)} to {percent(c.share.high)}"]
        for c in found.conclusions
    ]
    columns = html.columns("Conclusion", "Studies", "95 % Monte Carlo interval", left=1)
    caption = (
        "Proportion of studies in which each conclusion holds. A conclusion from a test holds if "
        "p is below the significance level after the given correction. Studies that could not be "
        "analysed count as studies in which no conclusion holds."
    )
    section.blocks.append(html.table(columns, rows, caption))
    return section
