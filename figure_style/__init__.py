"""One look for the models' figures: Okabe-Ito colours, quiet axes, units on every axis."""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

P = ParamSpec("P")

# Okabe and Ito's palette, told apart by colour-blind eyes; dashes tell it again in print.
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
SKY, PURPLE, GREY, BLACK = "#56B4E9", "#CC79A7", "#6E6E6E", "#222222"
CYCLE = (BLUE, ORANGE, GREEN, RED)
DASHES = ("-", "--", "-.", ":")

_STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.edgecolor": GREY,
    "grid.color": "#E4E4E4",
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "slipscale",
}


def styled(draw: Callable[P, Any]) -> Callable[P, Any]:
    """Draw a figure in the house's look, whatever the user's own matplotlib settings are."""

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Any:
        # matplotlib takes half a second to import: only a figure pays for it.
        from matplotlib import rc_context  # noqa: PLC0415

        with rc_context(_STYLE):
            return draw(*args, **kwargs)

    return drawn


def canvas(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (6.6, 4.2), **grid: Any
) -> Any:
    """Return a matplotlib figure and its axes.

    Parameters
    ----------
    rows, columns : int
        Panels.
    size : tuple of 2 floats
        Inches.
    **grid
        What ``Figure.subplots`` takes.
    """
    from matplotlib.figure import Figure  # noqa: PLC0415 - see `styled`

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, **grid)


def save(figure: Any, path: Path) -> None:
    """Write a figure as its suffix says; the same figure gives the same SVG bytes."""
    from matplotlib import rc_context  # noqa: PLC0415 - see `styled`

    with rc_context(_STYLE):
        metadata = {"Date": None} if path.suffix == ".svg" else None
        figure.savefig(path, dpi=150, metadata=metadata)


def note(
    axes: Any, text: str, at: tuple[float, float], to: tuple[float, float], **how: Any
) -> None:
    """Write a remark at a place of the data, with a thin line to what it is about."""
    axes.annotate(
        text,
        xy=to,
        xytext=at,
        color=BLACK,
        fontsize=9,
        arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.8},
        **how,
    )
