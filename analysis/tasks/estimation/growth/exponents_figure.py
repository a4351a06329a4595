"""Plot individual exponents before and after shrinkage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.writing.axes import tip
from slipscale.figure_style import BLUE, GREY, INK, PALE, canvas, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.analysis.tasks.estimation.growth.bayesian_growth import BayesianGrowth

#: Largest number of participants whose names fit on the axis.
NAMED_AT_MOST = 40
#: Height of a row and of the margins, in inches.
ROW, AROUND = 0.2, 1.3


@styled
def exponents(found: BayesianGrowth) -> Figure:
    """Plot each participant's least-squares exponent and shrunk exponent.

    Parameters
    ----------
    found : BayesianGrowth
        Result of `slipscale.analysis.tasks.estimation.growth.bayesian_growth.bayesian_growth`.
    """
    people = sorted(found.individuals, key=lambda one: one.exponent)
    rows = np.arange(len(people))
    figure, axes = canvas(size=(4.8, AROUND + ROW * min(len(people), NAMED_AT_MOST)))
    axes.axvspan(*found.interval, color="#CCE3F0", linewidth=0, zorder=0)
    axes.axvline(found.exponent, color=BLUE, linewidth=1.2, zorder=1, label="group, with interval")
    alone, drawn = (
        np.array([getattr(one, name) for one in people]) for name in ("least_squares", "exponent")
    )
    axes.hlines(rows, alone, drawn, color=PALE, linewidth=1.0, zorder=2)
    axes.plot(
        alone,
        rows,
        linestyle="none",
        marker="o",
        markerfacecolor="white",
        color=GREY,
        markersize=5,
        zorder=5,
        label="from own trials only",
    )
    for row, one in enumerate(people):
        low, high = one.interval
        axes.errorbar(
            one.exponent,
            row,
            xerr=[[one.exponent - low], [high - one.exponent]],
            color=INK,
            marker="o",
            markersize=5,
            elinewidth=1.2,
            zorder=4,
            label="shrunk towards the group, with credible intervals" if row == 0 else None,
        )[0].set_gid(
            tip(
                f"{one.participant}: {one.least_squares:.2f} from the participant's trials alone, "
                f"{one.exponent:.2f} after shrinkage"
            )
        )
    if len(people) <= NAMED_AT_MOST:
        axes.set_yticks(rows, [one.participant for one in people], fontsize=8)
    else:
        axes.set_yticks([])
        axes.set_ylabel(f"{len(people)} participants")
    axes.set_ylim(-0.7, len(people) - 0.3)
    axes.grid(visible=False, axis="y")
    axes.set_xlabel("Exponent of the power function")
    figure.legend(loc="outside lower center", ncols=1)
    return figure
