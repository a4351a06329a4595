"""Define the style of all figures, and write figure files that are identical on every run.

Matplotlib is imported only when a figure is plotted, because the import takes half a second.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from slipscale.figure_style.paper import current

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

P = ParamSpec("P")
R = TypeVar("R")

# Palette of Okabe and Ito, which is suitable for colour-blind readers.
BLUE, VERMILION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
PURPLE, INK, GREY, PALE = "#CC79A7", "#1F2933", "#52606D", "#7B8794"
CYCLE = (BLUE, ORANGE, GREEN, VERMILION)
DASHES = ("-", "--", "-.", ":")

#: Loosely typed, because Matplotlib's own type lists all settings.
STYLE: dict[Any, Any] = {
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
    "lines.linewidth": 1.8,
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
#: Metadata by file suffix, chosen so that files are identical on every run.
FORMATS: dict[str, dict[str, str | None]] = {
    ".svg": {"Date": None, "Creator": None},
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def settings() -> dict[Any, Any]:
    """Return Matplotlib's settings for a screen, or for the paper that figures are drawn for."""
    paper = current()
    return STYLE if paper is None else STYLE | paper.settings


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Decorate a plotting function so that Slipscale's style replaces the user's settings.

    Notebooks display the returned figure as SVG.
    """

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> R:
        import matplotlib as mpl
        from matplotlib.figure import Figure

        # The Matplotlib backend is not set, because setting it would import pyplot.
        defaults = {key: value for key, value in mpl.rcParamsDefault.items() if key != "backend"}
        with mpl.rc_context(defaults | settings()):
            made = draw(*args, **kwargs)
            if isinstance(made, Figure) and (paper := current()):
                paper.fit(made)
        if isinstance(made, Figure):
            made._repr_svg_ = partial(svg, made)  # type: ignore[attr-defined]
        return made

    return drawn


def canvas(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (6.6, 4.2), **grid: Any
) -> tuple[Figure, Any]:
    """Create a Matplotlib figure with axes.

    Parameters
    ----------
    rows, columns : int
        Numbers of panels.
    size : tuple of 2 floats
        Width and height on a screen in inches; see `slipscale.figure_style.paper` for papers.
    **grid
        Passed to ``Figure.subplots``.
    """
    from matplotlib.figure import Figure

    paper = current()
    figure = Figure(figsize=paper.size(*size) if paper else size, layout="constrained")
    return figure, figure.subplots(rows, columns, **grid)


def note(
    axes: Axes, text: str, at: tuple[float, float], to: tuple[float, float], **how: Any
) -> None:
    """Annotate a data point with text and a thin leader line."""
    axes.annotate(
        text,
        xy=to,
        xytext=at,
        color=INK,
        fontsize=9,
        arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.8},
        **how,
    )


@styled
def with_note(figure: Figure, text: str) -> Figure:
    """Add a line above a figure; legends are below figures."""
    figure.suptitle(text, x=0.01, ha="left", fontsize=8, color=GREY)
    return figure


def lay_out(figure: Figure) -> None:
    """Fix the layout of a figure, so that the figure looks the same in all formats."""
    import matplotlib as mpl

    if (engine := figure.get_layout_engine()) is not None:
        with mpl.rc_context(settings()):
            engine.execute(figure)
            if current():  # margins follow the size of the axes
                engine.execute(figure)
        figure.set_layout_engine("none")


def svg(figure: Figure, *, salt: str = "") -> str:
    """Return a figure as an SVG element with selectable text and without metadata.

    ``salt`` makes identifiers unique if there are several figures on a page.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    stream = io.StringIO()
    lay_out(figure)
    with mpl.rc_context(settings() | {"svg.hashsalt": f"slipscale {salt}", "svg.id": salt or None}):
        # `savefig` would draw the figure again to compute the layout, which is already fixed.
        backend: Any = FigureCanvasSVG(figure)
        backend.print_svg(stream, metadata=FORMATS[".svg"])
    text = re.sub(r"<metadata>.*?</metadata>", "", stream.getvalue(), flags=re.DOTALL)
    text = text[text.index("<svg") :].strip()
    # Matplotlib uses the group names figure_1, axes_1, ... in every figure.
    return re.sub(
        r' id="(figure|axes|patch|line2d|text|matplotlib\.axis|xtick|ytick|legend|'
        r'PathCollection|FillBetweenPolyCollection|LineCollection)_\d+"',
        "",
        text,
    )


def save(figure: Figure, path: Path, suffixes: tuple[str, ...] = ()) -> list[Path]:
    """Write a figure to files that are identical on every run, and return their paths.

    Parameters
    ----------
    figure : Figure
        Figure to write. Its layout is computed only once, so that it is the same in all formats.
    path : Path
        Path of the file. The path's suffix defines the format, unless ``suffixes`` are given.
    suffixes : tuple of str
        Keys of `FORMATS`. For each suffix, a file is written next to ``path``.
    """
    import matplotlib as mpl
    from matplotlib.backend_bases import get_registered_canvas_class

    paths = [path.with_suffix(suffix) for suffix in suffixes] or [path]
    lay_out(figure)
    with mpl.rc_context(settings()):
        for each in paths:
            # `savefig` would draw the figure again to compute the layout, which is already fixed.
            figure.set_dpi(mpl.rcParams["savefig.dpi"])
            backend: object = get_registered_canvas_class(each.suffix[1:])(figure)
            getattr(backend, f"print_{each.suffix[1:]}")(each, metadata=FORMATS[each.suffix])
    return paths
