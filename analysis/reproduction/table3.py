"""Compute Table III and Fig. 15 from a data set consistent with Table III.

The authors' raw data were never published. Agreement shows that the analysis computes the same
statistics as the paper; it is not evidence about perception.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial

from matplotlib.figure import Figure

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.published import biet2007
from slipscale.analysis.reproduction.comparison import Outcome
from slipscale.analysis.tasks.kind import Analysis
from slipscale.figure_style import with_note


@cache
def allowed() -> Analysis:
    """Analyse the data set consistent with Table III, without normalisation."""
    return analyse(biet2007.ALLOWED_DATASET, normalise="none")


def cell(row: biet2007.TableRow, statistic: str, *, figure: bool = False) -> Outcome:
    """Compare one cell of Table III, or the corresponding point in Fig. 15."""
    table = allowed().table3
    here = table["level"] == float(row.amplitude_um_pp)
    return Outcome(
        published=getattr(row, statistic),
        ours=float(table.loc[here, statistic].iloc[0]),
        unit="of 100",
        reason=("Fig. 15 plots Table III's means; " if figure else "") + biet2007.NOT_RAW_DATA,
        must_agree=True,
        by_construction=True,
        covers=("fig.15",) if figure else ("table.3",),
    )


def draw_fig15() -> Figure:
    """Plot Fig. 15 for the data set consistent with Table III."""
    from slipscale.analysis.tasks.estimation import figures as estimates

    figure = estimates.fig15(allowed().cells, unit="normalised, 0 to 100", paper=True)
    return with_note(
        figure, "A data set consistent with Table III; the authors never published their raw data."
    )


ITEMS: Mapping[str, Callable[[], Outcome]] = {
    f"table3.{row.amplitude_um_pp}.{statistic}": partial(cell, row, statistic)
    for row in biet2007.TABLE3
    for statistic in biet2007.STATISTICS
} | {
    f"fig15.{row.amplitude_um_pp}": partial(cell, row, "mean", figure=True)
    for row in biet2007.TABLE3
}

FIGURES: Mapping[str, Callable[[], Figure]] = {"fig15": draw_fig15}
