"""Print Table III and the main results on the terminal."""

from __future__ import annotations

import math

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from slipscale.analysis.published import biet2007
from slipscale.analysis.tasks.kind import Analysis
from slipscale.faults import harmless

TITLES = {"mean": "mean", "maximum_deviation": "max. dev.", "standard_deviation": "SD"}


def table3_table(analysis: Analysis) -> Table:
    """Return Table III as a rich table, with published values if the study is the paper's."""
    quantity = analysis.dataset.quantity
    beside = analysis.beside_paper
    table = Table(
        title=f"Table III: normalised estimates ({analysis.rule}), here and in the paper"
        if beside
        else f"Normalised estimates ({analysis.rule})",
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
    )
    table.add_column(
        escape(harmless(f"{quantity.name}\n{quantity.unit} {quantity.short_convention}".rstrip())),
        justify="right",
    )
    table.add_column("n", justify="right")
    for title in TITLES.values():
        table.add_column(f"{title}\nhere" if beside else title, justify="right", style="bold")
        if beside:
            table.add_column(f"{title}\npaper", justify="right", style="dim")
    for amplitude, n, *values in analysis.table3.itertuples(index=False):
        cells = [f"{amplitude:g}", str(n)]
        for name, value in zip(biet2007.STATISTICS, values, strict=True):
            # With one participant, there are no deviations.
            here = f"{value:.2f}" if math.isfinite(value) else "n/a"
            paper = [getattr(biet2007.BY_AMPLITUDE[amplitude], name)] if beside else []
            cells += [here, *paper]
        table.add_row(*cells)
    return table


def print_table3(analysis: Analysis, console: Console | None = None) -> None:
    """Print means and spreads as in Table III, if the analysis contains magnitude estimates."""
    if analysis.prepared is None:
        return
    (console or Console()).print(table3_table(analysis))


def print_answers(
    analysis: Analysis, console: Console | None = None, *, outside_only: bool = False
) -> None:
    """Print the main result of each task, as in the report's summary.

    Parameters
    ----------
    outside_only : bool
        Whether to print only the results of analyses from other packages.
    """
    kinds = [kind for kind in analysis.kinds if kind.package or not outside_only]
    for sentence in [text for kind in kinds for text in kind.answers(analysis)]:
        (console or Console()).print(harmless(sentence), markup=False, highlight=False)
