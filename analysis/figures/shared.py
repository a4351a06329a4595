"""What the figures of a data set share: the axis of amplitudes, and when lines become bands."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from urllib.parse import quote, unquote
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

#: What an artist's name starts with that carries a text to show under the pointer.
TIP = "tip-"
AMPLITUDE_LABEL = "Vibration amplitude (µm, peak to peak)"
#: More participants than this are drawn as bands of quantiles, not as single lines.
LINES_AT_MOST = 60


def amplitude_axis(axes: Axes, amplitudes: NDArray[np.float64]) -> None:
    """Ticks at the amplitudes that were presented, at their true distance."""
    span = float(amplitudes.max() - amplitudes.min()) or 1.0
    axes.set_xticks(amplitudes, [f"{value:g}" for value in amplitudes])
    axes.set_xlim(amplitudes.min() - 0.07 * span, amplitudes.max() + 0.07 * span)
    axes.set_xlabel(AMPLITUDE_LABEL)


def tip(text: str) -> str:
    """Return the name (gid) of an artist that shows a text under the pointer."""
    return TIP + quote(text)


def with_tips(svg: str) -> str:
    """Return an SVG element whose artists named by `tip` have their text as a title.

    >>> with_tips('<g id="tip-n%20%3D%203">')
    '<g><title>n = 3</title>'
    """
    return re.sub(
        f'<g id="{TIP}([^"]*)">',
        lambda match: f"<g><title>{escape(unquote(match[1]))}</title>",
        svg,
    )
