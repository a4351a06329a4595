"""How Slipscale's figures look, and how they are written: the same bytes every time.

Colours are Okabe and Ito's, which colour-blind readers tell apart; shapes differ as well.
"""

from __future__ import annotations

import functools
import io
import re
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import matplotlib as mpl

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, VERMILION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
PURPLE, INK, GREY, PALE = "#CC79A7", "#1F2933", "#52606D", "#7B8794"
#: More participants than this are drawn as bands of quantiles, not as single lines.
LINES_AT_MOST = 60
#: Typed loosely: matplotlib names each of its settings in its own type.
STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "#E4E7EB",
    "grid.linewidth": 0.8,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "slipscale",
    "pdf.fonttype": 42,
    "savefig.dpi": 200,
}

AMPLITUDE_LABEL = "Vibration amplitude (µm, peak to peak)"


P = ParamSpec("P")
R = TypeVar("R")


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw in the house's style, whatever the caller's settings are."""

    @functools.wraps(draw)
    def inner(*args: P.args, **kwargs: P.kwargs) -> R:
        with mpl.rc_context(dict(mpl.rcParamsDefault) | STYLE):
            return draw(*args, **kwargs)

    return inner


def amplitude_axis(axes: Axes, amplitudes: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    """Ticks at the amplitudes that were presented, at their true distance."""
    span = float(amplitudes.max() - amplitudes.min()) or 1.0
    axes.set_xticks(amplitudes, [f"{value:g}" for value in amplitudes])
    axes.set_xlim(amplitudes.min() - 0.07 * span, amplitudes.max() + 0.07 * span)
    axes.set_xlabel(AMPLITUDE_LABEL)


def lay_out(figure: Figure) -> None:
    """Place a figure's parts once, for all formats: the same picture in each, and sooner."""
    if figure.get_layout_engine() is not None:
        with mpl.rc_context(STYLE):
            figure.draw_without_rendering()
        figure.set_layout_engine("none")


def svg(figure: Figure, *, salt: str = "") -> str:
    """Return a figure as an SVG element: text selectable, no date, no metadata block.

    ``salt`` keeps the element's identifiers apart from those of other figures on the same page.
    """
    stream = io.StringIO()
    lay_out(figure)
    with mpl.rc_context(STYLE | {"svg.hashsalt": f"slipscale {salt}", "svg.id": salt or None}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = re.sub(r"<metadata>.*?</metadata>", "", stream.getvalue(), flags=re.DOTALL)
    text = text[text.index("<svg") :].strip()
    # Matplotlib names its groups figure_1, axes_1, ... in every figure: once a page is enough.
    return re.sub(
        r' id="(figure|axes|patch|line2d|text|matplotlib\.axis|xtick|ytick|legend|'
        r'PathCollection|FillBetweenPolyCollection|LineCollection)_\d+"',
        "",
        text,
    )


#: Suffix: the metadata that keeps the bytes the same on every run.
FORMATS: dict[str, dict[str, Any]] = {
    ".svg": {"Date": None, "Creator": None},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def save(
    figure: Figure, stem: Path, suffixes: tuple[str, ...] = (".svg", ".png", ".pdf")
) -> list[Path]:
    """Write a figure in several formats, the same bytes on every run; return the paths."""
    paths = []
    lay_out(figure)
    with mpl.rc_context(STYLE):
        for suffix in suffixes:
            path = stem.with_suffix(suffix)
            figure.savefig(path, metadata=FORMATS[suffix])
            paths.append(path)
    return paths


@styled
def with_note(figure: Figure, note: str) -> Figure:
    """Put a line under a figure that goes where the figure goes."""
    figure.supxlabel(note, x=0.01, ha="left", fontsize=8, color=GREY)
    return figure
