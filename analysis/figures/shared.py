"""What the figures of a data set share: the axis of amplitudes, and when lines become bands."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

AMPLITUDE_LABEL = "Vibration amplitude (µm, peak to peak)"
#: More participants than this are drawn as bands of quantiles, not as single lines.
LINES_AT_MOST = 60


def amplitude_axis(axes: Axes, amplitudes: NDArray[np.float64]) -> None:
    """Ticks at the amplitudes that were presented, at their true distance."""
    span = float(amplitudes.max() - amplitudes.min()) or 1.0
    axes.set_xticks(amplitudes, [f"{value:g}" for value in amplitudes])
    axes.set_xlim(amplitudes.min() - 0.07 * span, amplitudes.max() + 0.07 * span)
    axes.set_xlabel(AMPLITUDE_LABEL)
