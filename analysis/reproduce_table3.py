"""Table III and Fig. 15, computed by the analysis from a data set that Table III allows.

The authors' raw data were never published. Agreement shows that the analysis computes the
paper's statistics, not that anybody felt anything.
"""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING

from analysis import published
from analysis.pipeline import Analysis, analyse
from analysis.reproduce import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from matplotlib.figure import Figure


@cache
def allowed() -> Analysis:
    """Return the analysis of the data set that Table III allows, estimates as they are."""
    return analyse(published.ALLOWED_DATASET, normalise="none", write=False)


def cell(row: published.TableRow, statistic: str, *, figure: bool = False) -> Outcome:
    """Return one cell of Table III, or the point of Fig. 15 that shows it."""
    table = allowed().table3
    here = table["amplitude_um_pp"] == float(row.amplitude_um_pp)
    return Outcome(
        published=getattr(row, statistic),
        ours=float(table.loc[here, statistic].iloc[0]),
        unit="of 100",
        reason=("Fig. 15 plots Table III's means; " if figure else "") + published.NOT_RAW_DATA,
        must_agree=True,
    )


def draw_fig15() -> Figure:
    """Return Fig. 15 of the data set that Table III allows."""
    from analysis import figures  # noqa: PLC0415 - matplotlib takes a second to load

    figure = figures.fig15(allowed().cells, unit="normalised, 0 to 100")
    return figures.with_note(
        figure, "A data set that Table III allows; the authors' raw data were never published."
    )


ITEMS: Mapping[str, Callable[[], Outcome]] = {
    f"table3.{row.amplitude_um_pp}.{statistic}": partial(cell, row, statistic)
    for row in published.TABLE3
    for statistic in published.STATISTICS
} | {
    f"fig15.{row.amplitude_um_pp}": partial(cell, row, "mean", figure=True)
    for row in published.TABLE3
}

FIGURES: Mapping[str, Callable[[], Figure]] = {"fig15": draw_fig15}
