"""Figures as matplotlib `Figure` objects: made without a screen, the same bytes every time.

Colours are Okabe and Ito's, which colour-blind readers tell apart; shapes differ as well.
"""

from __future__ import annotations

import functools
import io
import re
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from analysis import published
from analysis.descriptives import complete, cousineau_morey

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import pandas as pd
    from matplotlib.axes import Axes

BLUE, VERMILION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
SKY, PURPLE, INK, PALE = "#56B4E9", "#CC79A7", "#1F2933", "#9AA5B1"
#: More participants than this are drawn as bands of quantiles, not as single lines.
LINES_AT_MOST = 60

#: Typed loosely: matplotlib names each of its settings in its own type.
STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#52606D",
    "axes.labelcolor": INK,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "#E4E7EB",
    "grid.linewidth": 0.8,
    "xtick.color": "#52606D",
    "ytick.color": "#52606D",
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


def _amplitude_axis(axes: Axes, amplitudes: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    """Ticks at the amplitudes that were presented, at their true distance."""
    span = float(amplitudes.max() - amplitudes.min()) or 1.0
    axes.set_xticks(amplitudes, [f"{value:g}" for value in amplitudes])
    axes.set_xlim(amplitudes.min() - 0.07 * span, amplitudes.max() + 0.07 * span)
    axes.set_xlabel(AMPLITUDE_LABEL)


def _individuals(axes: Axes, cells: pd.DataFrame, amplitudes: Any) -> None:
    """Each participant as a thin line; a crowd as bands that hold half and nine tenths."""
    values = cells.to_numpy(float)
    if len(values) <= LINES_AT_MOST:
        for number, row in enumerate(values):
            axes.plot(
                amplitudes,
                row,
                color=PALE,
                linewidth=0.8,
                marker="o",
                markersize=3,
                markeredgewidth=0,
                alpha=0.75,
                clip_on=False,
                zorder=1,
                label="one participant" if number == 0 else None,
            )
        return
    low, q1, q3, high = np.nanquantile(values, [0.05, 0.25, 0.75, 0.95], axis=0)
    axes.fill_between(
        amplitudes, low, high, color="#E4E7EB", linewidth=0, label="90 % of participants"
    )
    axes.fill_between(
        amplitudes, q1, q3, color="#CBD2D9", linewidth=0, label="50 % of participants"
    )


@styled
def fig15(
    cells: pd.DataFrame,
    *,
    unit: str = "% of the scale",
    confidence: float = 0.95,
    compare: bool = True,
) -> Figure:
    """Draw the paper's Fig. 15: mean slipperiness against amplitude, with every participant.

    Parameters
    ----------
    cells : DataFrame, shape (participants, amplitudes)
        Normalised mean estimates.
    unit : str
        The unit of the estimates.
    confidence : float
        Of the within-participant intervals (Cousineau-Morey).
    compare : bool
        Show the paper's means where the amplitudes are the paper's.
    """
    figure = Figure(figsize=(6.8, 4.4), layout="constrained")
    axes = figure.add_subplot()
    amplitudes = cells.columns.to_numpy(float)
    _individuals(axes, cells, amplitudes)
    whole = complete(cells).to_numpy(float)
    half = cousineau_morey(whole, confidence) if len(whole) else np.full(len(amplitudes), np.nan)
    axes.errorbar(
        amplitudes,
        cells.mean().to_numpy(float),
        yerr=None if np.isnan(half).any() else half,
        color=BLUE,
        linewidth=2,
        marker="o",
        markersize=6.5,
        capsize=4,
        capthick=1.6,
        elinewidth=1.6,
        zorder=4,
        label=f"mean, {100 * confidence:g} % within-participant interval"
        if not np.isnan(half).any()
        else "mean",
    )
    paper = published.published_means()
    if compare and set(amplitudes) <= set(paper):
        axes.plot(
            amplitudes,
            [paper[value] for value in amplitudes],
            linestyle="none",
            marker="D",
            markersize=8.5,
            markerfacecolor="none",
            markeredgecolor=VERMILION,
            markeredgewidth=1.6,
            zorder=5,
            label="mean in the paper (Table III)",
        )
    _amplitude_axis(axes, amplitudes)
    axes.set_ylabel(f"Perceived slipperiness\n({unit})")
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return figure


def svg(figure: Figure, *, width: str | None = None) -> str:
    """Return a figure as an SVG element: text selectable, no date, no metadata block."""
    stream = io.StringIO()
    with mpl.rc_context(STYLE):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = re.sub(r"<metadata>.*?</metadata>", "", stream.getvalue(), flags=re.DOTALL)
    text = text[text.index("<svg") :].strip()
    if width is not None:
        text = re.sub(
            r'width="[^"]*pt" height="[^"]*pt"|height="[^"]*pt" width="[^"]*pt"',
            f'width="{width}"',
            text,
            count=1,
        )
    return text


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
    with mpl.rc_context(STYLE):
        for suffix in suffixes:
            path = stem.with_suffix(suffix)
            figure.savefig(path, metadata=FORMATS[suffix])
            paths.append(path)
    return paths


@styled
def with_note(figure: Figure, note: str) -> Figure:
    """Put a line under a figure that goes where the figure goes."""
    figure.supxlabel(note, x=0.01, ha="left", fontsize=8, color="#52606D")
    return figure
