"""Set up the amplitude axis of figures, and add tooltips to SVG elements."""

from __future__ import annotations

import re
from urllib.parse import quote, unquote
from xml.sax.saxutils import escape

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

#: Name prefix for artists with a tooltip.
TIP = "tip-"
#: With more participants than this, quantile bands are drawn instead of individual lines.
LINES_AT_MOST = 60


#: Levels that span a larger ratio have a logarithmic axis, unless they are plate amplitudes.
LINEAR_RATIO = 50.0
#: Smallest distance between ticks, as a proportion of the axis.
CLOSEST_TICKS = 0.06
#: Width of a digit relative to the font size.
DIGIT = 0.62


def amplitude_axis(
    axes: Axes, amplitudes: NDArray[np.float64], quantity: Quantity = PLATE_AMPLITUDE
) -> None:
    """Place ticks at the presented levels, to scale.

    If the levels need a logarithmic axis and include 0, the axis is linear below the smallest
    positive level.
    """
    above = amplitudes[amplitudes > 0]
    if over_decades(amplitudes, quantity):
        smallest = float(above.min())
        if len(above) == len(amplitudes):
            axes.set_xscale("log")
        else:
            axes.set_xscale("symlog", linthresh=smallest)
        low = smallest / 2 if len(above) == len(amplitudes) else -0.3 * smallest
        axes.set_xlim(low, 2 * amplitudes.max())
    else:
        span = float(amplitudes.max() - amplitudes.min()) or 1.0
        axes.set_xlim(amplitudes.min() - 0.07 * span, amplitudes.max() + 0.07 * span)
    ticks = apart(axes, amplitudes)
    axes.set_xticks(ticks, [f"{value:g}" for value in ticks])
    axes.set_xticks([], minor=True)
    axes.set_xlabel(quantity.axis)


def over_decades(levels: NDArray[np.float64], quantity: Quantity) -> bool:
    """Return whether the levels span so wide a range that they need a logarithmic axis."""
    above = levels[levels > 0]
    return not quantity.of_plate and len(above) > 1 and above.max() > LINEAR_RATIO * above.min()


def apart(axes: Axes, levels: NDArray[np.float64]) -> list[float]:
    """Return levels whose tick labels do not overlap, given the axis scale and limits."""
    transform = axes.get_xaxis_transform()
    places = transform.transform([(level, 0.0) for level in levels])[:, 0]
    size = mpl.rcParams["font.size"] * axes.figure.dpi / 72
    kept: list[float] = []
    end = -np.inf
    for level, place in zip(levels.tolist(), places, strict=True):
        half = max(CLOSEST_TICKS * axes.bbox.width, DIGIT * size * (len(f"{level:g}") + 1)) / 2
        if place - half >= end:
            kept.append(level)
            end = place + half
    return kept


def tip(text: str) -> str:
    """Encode a tooltip in the name (gid) of an artist."""
    return TIP + quote(text)


def with_tips(svg: str) -> str:
    """Add tooltips to the elements of an SVG whose names were returned by `tip`.

    >>> with_tips('<g id="tip-n%20%3D%203">')
    '<g><title>n = 3</title>'
    """
    return re.sub(
        f'<g id="{TIP}([^"]*)">',
        lambda match: f"<g><title>{escape(unquote(match[1]))}</title>",
        svg,
    )
