"""Sizes and styles of figures for papers."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from textwrap import wrap
from typing import TYPE_CHECKING, Any, TypeVar

from slipscale.faults import UserError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

T = TypeVar("T")

CM_PER_INCH = 2.54
CM = {"cm": 1.0, "mm": 0.1, "in": CM_PER_INCH}
#: Narrower figures have no space for their text, and wider figures fit on no page.
WIDTHS_CM = (8.0, 30.0)
#: Smallest and largest size of text.
TEXT_PT = (7.0, 9.0)
#: Size of lines and markers relative to figures on a screen.
STROKES = 0.75
#: Longest text of an axis relative to the space for it.
LONGEST = 0.92
#: Exponent of the height relative to the width: text shrinks less than the figure.
HEIGHT = 0.75


@dataclass(frozen=True, slots=True, kw_only=True)
class PaperStyle:
    """The style of figures for a paper: text of 7 to 9 pt, and pictures with 600 dots per inch.

    Parameters
    ----------
    width_cm : float
        Width of a figure.
    grid : bool
        Whether axes have grid lines.

    Raises
    ------
    UserError
        If the width is outside `WIDTHS_CM`.
    """

    width_cm: float
    grid: bool = True

    def __post_init__(self) -> None:
        low, high = WIDTHS_CM
        if not low <= self.width_cm <= high:
            raise UserError(
                "width of figures: {width_cm:g} cm, expected {low:g} to {high:g} cm",
                width_cm=self.width_cm,
                low=low,
                high=high,
            )

    @property
    def settings(self) -> dict[Any, Any]:
        """Matplotlib's settings that differ from those for a screen."""
        return {
            "font.size": 8.0,
            "axes.titlesize": 9.0,
            "legend.fontsize": 7.5,
            "axes.grid": self.grid,
            "grid.linewidth": 0.5,
            "axes.linewidth": 0.6,
            "xtick.major.width": 0.6,
            "ytick.major.width": 0.6,
            "savefig.dpi": 600,
        }

    def size(self, width_in: float, height_in: float) -> tuple[float, float]:
        """Return a figure's width and height in inches, given those on a screen."""
        width = self.width_cm / CM_PER_INCH
        return width, height_in * (width / width_in) ** HEIGHT

    def fit(self, figure: Figure) -> None:
        """Limit the size of a figure's text, wrap it, and make lines and markers thinner."""
        import numpy as np
        from matplotlib.collections import Collection
        from matplotlib.lines import Line2D
        from matplotlib.text import Text

        for text in _all(figure, Text):
            text.set_fontsize(min(max(text.get_fontsize(), TEXT_PT[0]), TEXT_PT[1]))
        for line in _all(figure, Line2D):
            line.set_linewidth(STROKES * line.get_linewidth())
            line.set_markersize(STROKES * line.get_markersize())
        for marks in _all(figure, Collection):
            marks.set_linewidth((STROKES * np.asarray(marks.get_linewidth())).tolist())
        _stack_legends(figure)
        _lay_out(figure)
        for axes in figure.axes:
            label, height = axes.yaxis.label, axes.bbox.height
            middle = (axes.bbox.y0 + axes.bbox.y1) / 2
            whole = 2 * min(middle, figure.bbox.height - middle)
            _wrap(label, label.get_window_extent().height / (height if figure.axes[1:] else whole))
        _lay_out(figure)  # wrapped labels leave less width
        for axes in figure.axes:
            title = axes.set_title(axes.get_title("left"), loc="left")
            for text in (title, axes.xaxis.label):
                _wrap(text, text.get_window_extent().width / axes.bbox.width)
            if legend := axes.get_legend():
                legend.set_loc("best")


def _lay_out(figure: Figure) -> None:
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)


def _all(figure: Figure, kind: type[T]) -> list[T]:
    return [each for each in figure.findobj() if isinstance(each, kind)]


def _wrap(text: Text, proportion: float) -> None:
    """Break a text into lines that fit, given its proportion of the available length."""
    if proportion > LONGEST:
        words = " ".join(text.get_text().split())
        longest = max(map(len, text.get_text().splitlines()))
        lines = wrap(words, int(longest * LONGEST / proportion), break_long_words=False)
        text.set_text("\n".join(lines))


def _stack_legends(figure: Figure) -> None:
    """Give a legend that is wider than its figure a single column."""
    for legend in list(figure.legends):
        if legend.get_window_extent().width < figure.bbox.width:
            continue
        shown = [text.get_text() for text in legend.get_texts()]
        handles = {
            label: handle
            for axes in figure.axes
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        before = legend.get_window_extent().height
        legend.remove()
        below = figure.legend(
            [handles[label] for label in shown], shown, loc="outside lower center", ncols=1
        )
        higher = below.get_window_extent().height - before
        figure.set_figheight(figure.get_figheight() + higher / figure.dpi)


#: Styles by name.
STYLES = {
    "ieee": PaperStyle(width_cm=8.9),
    "apa": PaperStyle(width_cm=8.25, grid=False),
}
_CURRENT: ContextVar[PaperStyle | None] = ContextVar("paper_style", default=None)


def current() -> PaperStyle | None:
    """Return the style of the figures that are drawn now; None for a screen."""
    return _CURRENT.get()


@contextmanager
def drawn_for(style: PaperStyle | None) -> Iterator[None]:
    """Draw and save all figures of a block in a style; None draws figures for a screen."""
    token = _CURRENT.set(style)
    try:
        yield
    finally:
        _CURRENT.reset(token)


def paper_style(width: str | None = None, style: str | None = None) -> PaperStyle | None:
    """Return the style for a width or a name, or None without both.

    Parameters
    ----------
    width : str, optional
        Number with the unit cm, mm or in, such as "8.9cm". Replaces the width of ``style``.
    style : str, optional
        Key of `STYLES`.

    Raises
    ------
    UserError
        If the width cannot be read, or if there is no such style.

    >>> paper_style("89 mm"), paper_style(style="apa").width_cm
    (PaperStyle(width_cm=8.9, grid=True), 8.25)
    """
    if style is not None and style not in STYLES:
        raise UserError(
            "style of figures: '{style}', expected one of {known}",
            style=style,
            known=", ".join(STYLES),
        )
    named = STYLES[style] if style else None
    if width is None:
        return named
    found = re.fullmatch(r"\s*(\d+(?:[.,]\d+)?)\s*(cm|mm|in)\s*", width)
    if not found:
        raise UserError(
            "width of figures: '{width}', expected a number with cm, mm or in, such as 8.9cm",
            width=width,
        )
    width_cm = round(float(found[1].replace(",", ".")) * CM[found[2]], 6)
    return PaperStyle(width_cm=width_cm, grid=named.grid if named else True)
