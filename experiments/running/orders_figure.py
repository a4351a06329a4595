"""Draw the orders of surfaces for all planned participants as coloured cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from slipscale.figure_style import INK, canvas, styled
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.experiments.steps.trial import Trial
    from slipscale.stimuli.surface import Stimulus

#: Maximum number of participants whose rows can be distinguished in one figure.
MOST = 40
#: Maximum number of trials for which the amplitudes are printed in the cells.
MOST_NAMED = 30


@styled
def orders_figure(
    people: Sequence[tuple[str, Sequence[tuple[Trial, Stimulus]]]],
    quantity: Quantity = PLATE_AMPLITUDE,
) -> Figure:
    """Draw one row per participant and one cell per trial, coloured by level.

    Parameters
    ----------
    people : sequence of (str, sequence)
        One (label, trials) pair per participant, where ``trials`` lists the trials of one run in
        order of presentation as (trial, surface) pairs.
    quantity : Quantity
        Quantity and unit of the levels.
    """
    shown = people[:MOST]
    trials = max(len(own) for _, own in shown)
    table = np.full((len(shown), trials), np.nan)
    for row, (_, own) in enumerate(shown):
        table[row, : len(own)] = [_level(surface) for _, surface in own]
    figure, axes = canvas(size=(7.4, 1.4 + 0.24 * len(shown)))
    image = axes.imshow(table, aspect="auto", cmap="cividis")
    if trials <= MOST_NAMED:
        middle = (np.nanmin(table) + np.nanmax(table)) / 2
        for (row, trial), value in np.ndenumerate(table):
            if np.isfinite(value):
                colour = "#FFFFFF" if value < middle else "#000000"
                axes.annotate(
                    f"{value:g}", (trial, row), ha="center", va="center", fontsize=7, color=colour
                )
    for place, name in _parts(shown[0][1]):
        axes.axvline(place - 0.5, color="#FFFFFF", linewidth=2.5)
        axes.annotate(
            name, (place - 0.5, 1.01), xycoords=("data", "axes fraction"), ha="left", va="bottom",
            fontsize=7.5, color=INK,
        )  # fmt: skip
    axes.set_yticks(range(len(shown)), [label for label, _ in shown])
    axes.set_xticks(range(trials), [str(number + 1) for number in range(trials)])
    if trials > MOST_NAMED:
        axes.set_xticks(range(9, trials, 10), [str(number + 1) for number in range(9, trials, 10)])
    axes.grid(visible=False)
    axes.set(xlabel="Presentation", ylabel="Participant")
    figure.colorbar(image, ax=axes).set_label(f"{quantity.title}, {quantity.unit_in_full}")
    return figure


def _level(surface: Stimulus) -> float:
    return surface.settled_level if surface.name else surface.level


def _parts(own: Sequence[tuple[Trial, Stimulus]]) -> list[tuple[int, str]]:
    """Return the start position and the name of each part of a run."""
    found: list[tuple[int, str]] = []
    for place, (trial, _) in enumerate(own):
        name = f"{trial.task},\n{trial.phase}" if trial.phase == "practice" else f"{trial.task}\n"
        if not found or found[-1][1] != name:
            found.append((place, name))
    return found
