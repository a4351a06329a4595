"""Plot exponents against Weber fractions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from slipscale.analysis.tasks.exponent_and_weber.statistics import EKMAN, PUBLISHED
from slipscale.analysis.writing.axes import tip
from slipscale.figure_style import BLUE, GREY, PALE, VERMILION, canvas, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.tasks.exponent_and_weber.statistics import ExponentAndWeber


@styled
def exponent_and_weber(found: ExponentAndWeber) -> Figure:
    """Plot participants, means with intervals, and the curve of Ekman's law."""
    figure, axes = canvas()
    weber = np.array([each.weber_fraction for each in found.participants])
    own = np.array([each.exponent for each in found.participants])
    # An interval that reaches 0 has no end on a logarithmic axis: it extends beyond the figure.
    ends = [end for end in (*weber, *found.weber_fraction.interval) if end > 0]
    fine = np.geomspace(min(ends) / 1.4, max(ends) * 1.4, 100)
    low, high = (np.log1p(k) / np.log1p(fine) for k in PUBLISHED)
    axes.fill_between(fine, low, high, color=PALE, linewidth=0, alpha=0.6)
    axes.plot(fine, np.log1p(EKMAN) / np.log1p(fine), color=GREY, label="Ekman's law, 0.03")
    for each in found.participants:
        axes.plot(
            [each.weber_fraction],
            [each.exponent],
            "o",
            color=BLUE,
            markersize=4,
            gid=tip(
                f"{each.participant}: exponent {each.exponent:.2f}, Weber fraction "
                f"{each.weber_fraction:.3f}"
            ),
        )
    axes.plot([], "o", color=BLUE, markersize=4, label="participants")
    x, y = found.weber_fraction, found.exponent
    axes.plot(list(x.interval), [y.value] * 2, color=VERMILION)
    axes.plot([x.value] * 2, list(y.interval), color=VERMILION, label="means with intervals")
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlim(fine[0], fine[-1])
    tops = [*own, *y.interval]
    axes.set_ylim(min(0.0, *tops) - 0.05, max(tops) * 1.25)
    axes.set_xlabel("Weber fraction")
    axes.set_ylabel("Exponent")
    axes.legend()
    return figure
