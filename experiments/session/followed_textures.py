"""Textures that follow the finger: compute the plate command for each frame.

A texture follows the finger only if a source measures the finger's position and
`followed_texture` finds that the plate supports it. Otherwise the plate plays the texture without
the finger's position. Before a readback is compared with a command, the plate settles at the
texture's mean.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.contact.followed_texture import FollowedTexture, followed_texture

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.contact.source import Sample
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.surface import Surface

LEAST_CHANGE_UM = 0.005  # smaller changes cannot be felt and would only load the line


class Following:
    """Makes textures follow the finger if the plate supports it.

    Parameters
    ----------
    plate : PlateDriver
    clock : Clock
    place_known : bool
        Whether a source measures the finger's position.
    """

    def __init__(self, plate: PlateDriver, clock: Clock, *, place_known: bool) -> None:
        self._plate = plate
        self._clock = clock
        self._place_known = place_known
        self._followed: FollowedTexture | None = None
        self._told_level: float | None = None  # None: still at the mean

    def presented_as(self, surface: Surface) -> Surface:
        """Return the surface to present first: the mean of a followed texture, else the surface."""
        found = followed_texture(surface, self._plate) if self._place_known else None
        self._followed, self._told_level = found, None
        return found.mean if found else surface

    def see(self, samples: list[Sample]) -> None:
        """Command the amplitude for the finger's current position."""
        if self._followed is None:
            return
        self._followed.see(samples)
        due_level = self._followed.level(self._clock.now())
        before_level = self._told_level
        if before_level is None:
            before_level = self._followed.mean.level
        if abs(due_level - before_level) >= LEAST_CHANGE_UM:
            self._plate.follow(due_level)
            self._told_level = due_level

    def settle(self) -> None:
        """Present a followed texture's mean again, so that it can be compared with a command."""
        if self._followed is not None and self._told_level is not None:
            self._plate.present(self._followed.mean)
            self._told_level = None
