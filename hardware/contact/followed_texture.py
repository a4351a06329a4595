"""A texture under a finger whose place is known: which amplitude is due now.

A command takes some time to reach the plate. So the amplitude is that of the place where the finger
will be by then, by its speed over the last samples.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hardware.contact.source import Sample
    from stimuli.texture import Grating

SPEED_OVER_S = 0.04  # shorter, and noise passes for speed; longer, and a turn is seen late
LOST_S = 0.2  # older, and the finger's place is not known


class FollowedTexture:
    """Follows a finger over a grating.

    Parameters
    ----------
    grating : Grating
    lag_s : float
        From a command to the plate's amplitude.
    """

    def __init__(self, grating: Grating, lag_s: float) -> None:
        self._grating = grating
        self._lag_s = lag_s
        self._last: deque[tuple[float, float]] = deque()

    def see(self, samples: Iterable[Sample]) -> None:
        """Take note of where the finger is."""
        for each in samples:
            self._last.append((each.time_s, each.values[0]))
        while len(self._last) > 2 and self._last[-1][0] - self._last[1][0] >= SPEED_OVER_S:  # noqa: PLR2004 - two tell a speed
            self._last.popleft()

    def amplitude_um_pp(self, now_s: float) -> float:
        """Return the amplitude to command now; the mean where the finger's place is not known."""
        if not self._last or now_s - self._last[-1][0] > LOST_S:
            return self._grating.mean_um_pp
        time_s, place_mm = self._last[-1]
        first_s, first_mm = self._last[0]
        passed_s = time_s - first_s
        speed_mm_s = (place_mm - first_mm) / passed_s if 0 < passed_s <= LOST_S else 0.0
        return self._grating.amplitude_at_um_pp(
            place_mm + speed_mm_s * (now_s - time_s + self._lag_s)
        )
