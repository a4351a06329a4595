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
from matplotlib.ticker import PercentFormatter

from analysis import inference, published, scaling
from analysis.descriptives import complete, cousineau_morey

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
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
    figure.supxlabel(note, x=0.01, ha="left", fontsize=8, color="#52606D")
    return figure


@styled
def growth(
    logs: pd.DataFrame,
    found: Mapping[str, Any],
    *,
    unit: str = "% of the scale",
    confidence: float = 0.95,
) -> Figure:
    """Draw the growth of sensation: models on linear axes, power functions on logarithmic ones.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Mean natural logarithms of normalised estimates; 0 µm is left out.
    found : Mapping
        `analysis.scaling.growth`'s result, or its reason.
    unit : str
        Of the estimates.
    confidence : float
        Of Student's intervals around the geometric means.
    """
    figure = Figure(figsize=(6.8, 3.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    above = logs.loc[:, logs.columns.to_numpy(float) > 0]
    amplitudes = above.columns.to_numpy(float)
    centre = above.mean().to_numpy(float)
    low, high = _student(above, confidence)
    fine = np.linspace(amplitudes.min(), amplitudes.max(), 200)
    models = found["amplitude"]["models"] if "amplitude" in found else {}
    for (name, model), colour, dash in zip(
        models.items(),
        (BLUE, GREEN, ORANGE, PURPLE),
        ("-", (0, (1, 1.2)), (0, (5, 2)), "-."),
        strict=False,
    ):
        theta = model_parameters(name, model)
        curve, points = (scaling.MODELS[name].log_f(x, theta) for x in (fine, amplitudes))
        left.plot(
            fine,
            np.exp(curve + (centre - points).mean()),
            color=colour,
            linestyle=dash,
            linewidth=1.8,
            label=f"{name}, ΔAICc {model['delta_aicc']:.1f}"
            if model["delta_aicc"] is not None
            else name,
            zorder=2,
        )
    for axes in (left, right):
        axes.errorbar(
            amplitudes,
            np.exp(centre),
            yerr=[np.exp(centre) - np.exp(low), np.exp(high) - np.exp(centre)],
            color=INK,
            linestyle="none",
            marker="o",
            markersize=5.5,
            capsize=3,
            zorder=4,
        )
        axes.set_xlabel("Amplitude (µm, peak to peak)")
    left.set_ylabel(f"Perceived slipperiness\n({unit}), geometric means")
    left.set_xlim(left=0)
    left.set_ylim(bottom=0)
    left.set_title("Growth functions")
    if models:
        left.legend(loc="lower right")
    for row in np.exp(above.to_numpy(float))[:LINES_AT_MOST]:
        right.plot(amplitudes, row, color=PALE, linewidth=0.8, alpha=0.75, zorder=1)
    slope, level = np.polyfit(np.log(amplitudes), centre, 1)
    right.plot(
        amplitudes, np.exp(level + slope * np.log(amplitudes)), color=BLUE, linewidth=2, zorder=3
    )
    right.set_xscale("log")
    right.set_yscale("log")
    right.set_xticks(amplitudes, [f"{value:g}" for value in amplitudes])
    right.minorticks_off()
    right.yaxis.set_major_formatter("{x:g}")
    right.set_title("Logarithmic axes (0 µm omitted)")
    return figure


def model_parameters(name: str, model: Mapping[str, Any]) -> Any:
    """Return a fitted model's parameters as its function takes them."""
    values = [float(value) for value in model["parameters"].values()]
    return np.array([np.log(values[0])] if name == "fechner" else values)


def _student(table: pd.DataFrame, confidence: float) -> tuple[Any, Any]:
    """Return Student's intervals of the columns' means."""
    from scipy import stats  # noqa: PLC0415 - a second's import

    n = table.notna().sum().to_numpy(float)
    error = table.std(ddof=1).to_numpy(float) / np.sqrt(n)
    half = np.nan_to_num(stats.t.ppf((1 + confidence) / 2, np.maximum(n - 1, 1)) * error)
    centre = table.mean().to_numpy(float)
    return centre - half, centre + half


@styled
def residuals(logs: pd.DataFrame) -> Figure:
    """Draw what participants' and amplitudes' means leave: against a normal, and by amplitude.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        Complete mean logarithms.
    """
    from scipy import stats  # noqa: PLC0415 - a second's import

    figure = Figure(figsize=(6.8, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    left_over = inference.additive_residuals(logs.to_numpy(float))
    ordered = np.sort(left_over.ravel())
    expected = stats.norm.ppf((np.arange(ordered.size) + 0.5) / ordered.size) * ordered.std(ddof=1)
    shown = np.unique(np.linspace(0, ordered.size - 1, min(ordered.size, 400)).astype(int))
    span = [min(expected[0], ordered[0]), max(expected[-1], ordered[-1])]
    left.plot(span, span, color=PALE, linewidth=1.2, zorder=1)
    left.plot(expected[shown], ordered[shown], "o", color=BLUE, markersize=3.5, markeredgewidth=0)
    left.set_xlabel("Expected of a normal distribution")
    left.set_ylabel("Residual (natural logarithm)")
    left.set_title("Normality")
    amplitudes = logs.columns.to_numpy(float)
    right.axhline(0, color=PALE, linewidth=1.2)
    for amplitude, column in zip(amplitudes, left_over.T, strict=True):
        some = column[:: max(1, len(column) // 200)]
        right.plot(
            np.full(len(some), amplitude),
            some,
            "o",
            color=BLUE,
            markersize=3.5,
            markeredgewidth=0,
            alpha=0.6,
        )
    _amplitude_axis(right, amplitudes)
    right.set_title("Spread at each amplitude")
    return figure


@styled
def difference(found: Mapping[str, Any], *, confidence: float = 0.95) -> Figure:
    """Draw the proportion of "yes" at each step and on catch steps, with exact intervals.

    Parameters
    ----------
    found : Mapping
        `analysis.difference.analyse_differences`'s result.
    """
    steps = list(found["steps"])
    catch = found["catch"]
    labels = [f"{row['from_um_pp']:g} → {row['to_um_pp']:g} µm" for row in steps]
    rows = [(row["yes"], row["n"], row["ci95"], BLUE, "o") for row in steps]
    if catch["n"]:
        labels.append("catch: no change")
        rows.append((catch["yes"], catch["n"], catch["ci95"], VERMILION, "s"))
    figure = Figure(figsize=(6.8, 0.9 + 0.42 * len(rows)), layout="constrained")
    axes = figure.add_subplot()
    for place, (yes, n, (low, high), colour, marker) in enumerate(rows):
        share = yes / n
        axes.errorbar(
            share,
            place,
            xerr=[[share - low], [high - share]],
            color=colour,
            marker=marker,
            markersize=7,
            capsize=4,
            linewidth=1.8,
            clip_on=False,
            zorder=3,
        )
        axes.annotate(
            f"{yes} of {n}",
            (1.03, place),
            xycoords=("axes fraction", "data"),
            va="center",
            fontsize=8.5,
            color="#52606D",
            annotation_clip=False,
        )
    axes.set_yticks(range(len(rows)), labels)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_xlim(0, 1)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0))
    axes.grid(visible=True, axis="x")
    axes.grid(visible=False, axis="y")
    axes.set_xlabel(f'"Yes, I feel a difference" (exact {100 * confidence:g} % intervals)')
    return figure
