"""A texture under a finger with known position: computes the amplitude due now.

A command takes some time to reach the plate and holds until the next one. The amplitude is
therefore that of the predicted finger position at that time, from its speed over the last samples.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating

if TYPE_CHECKING:
    from collections.abc import Iterable

    from slipscale.hardware.contact.source import Sample
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.surface import Surface

SPEED_OVER_S = 0.04  # a shorter time mistakes noise for speed; a longer one detects turns late
LONGEST_HELD_S = 0.05  # between frames
LOST_S = 0.2  # after this, the finger's position is unknown


class FollowedTexture:
    """Follows a finger over a grating.

    Parameters
    ----------
    grating : Grating
    lag_s : float
        Delay from a command to the plate's amplitude.
    """

    def __init__(self, grating: Grating, lag_s: float) -> None:
        self._grating = grating
        self._lag_s = lag_s
        self._last: deque[tuple[float, float]] = deque()
        self._asked_s: float | None = None

    @property
    def mean(self) -> VirtualSurface:
        """The plain surface at which the plate settles before it follows the finger."""
        return VirtualSurface(level=self._grating.settled_level, label=self._grating.label)

    def see(self, samples: Iterable[Sample]) -> None:
        """Update the finger's position from samples."""
        for each in samples:
            self._last.append((each.time_s, each.values[0]))
        while len(self._last) > 2 and self._last[-1][0] - self._last[1][0] >= SPEED_OVER_S:  # noqa: PLR2004 - two tell a speed
            self._last.popleft()

    def level(self, now_s: float) -> float:
        """Return the amplitude to command now; the mean if the finger's position is unknown."""
        asked_s, self._asked_s = self._asked_s, now_s
        held_s = min(now_s - asked_s, LONGEST_HELD_S) if asked_s is not None else 0.0
        if not self._last or now_s - self._last[-1][0] > LOST_S:
            return self._grating.settled_level
        time_s, place_mm = self._last[-1]
        first_s, first_mm = self._last[0]
        passed_s = time_s - first_s
        speed_mm_s = (place_mm - first_mm) / passed_s if 0 < passed_s <= LOST_S else 0.0
        ahead_s = now_s - time_s + self._lag_s + held_s / 2
        return self._grating.level_at(place_mm + speed_mm_s * ahead_s)


def followed_texture(surface: Surface, plate: PlateDriver) -> FollowedTexture | None:
    """Return an object that follows the finger; None for a plain surface or an incapable plate."""
    if not isinstance(surface, Grating) or surface.depth_level == 0 or plate.follow_lag_s is None:
        return None
    return FollowedTexture(surface, plate.follow_lag_s)
