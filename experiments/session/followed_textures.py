"""Textures that follow the finger: what the plate is commanded at each frame.

A texture follows the finger only if a source measures its place and `followed_texture` finds that
the plate supports it; otherwise the plate plays it by itself. Before a readback is compared with a
command, the plate settles at the texture's mean.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.contact.followed_texture import FollowedTexture, followed_texture

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.contact.source import Sample
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.surface import Surface

LEAST_CHANGE_UM = 0.005  # less is not felt, and loads the line


class Following:
    """What of a session's surfaces follows the finger: textures, on a plate that can.

    Parameters
    ----------
    plate : PlateDriver
    clock : Clock
    place_known : bool
        Whether a source tells the finger's place.
    """

    def __init__(self, plate: PlateDriver, clock: Clock, *, place_known: bool) -> None:
        self._plate = plate
        self._clock = clock
        self._place_known = place_known
        self._followed: FollowedTexture | None = None
        self._told_level: float | None = None  # where it has gone from its mean

    def presented_as(self, surface: Surface) -> Surface:
        """Return what the plate makes of a surface at first: of a followed texture the mean."""
        found = followed_texture(surface, self._plate) if self._place_known else None
        self._followed, self._told_level = found, None
        return found.mean if found else surface

    def see(self, samples: list[Sample]) -> None:
        """Command what is due where the finger is; the plate makes the surface."""
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
        """Have a plate that followed settle at the mean, which can be compared with a command."""
        if self._followed is not None and self._told_level is not None:
            self._plate.present(self._followed.mean)
            self._told_level = None
