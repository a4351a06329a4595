"""Make textures follow the finger, by computing the plate command for each frame.

A texture follows the finger only if a source measures the property that the texture depends on, and
if `followed_texture` finds that the plate supports it. Otherwise the plate plays the texture
independently of the finger. Before the readback is compared with the command, the plate returns to
the level at which the texture first settled.
"""

from __future__ import annotations

from collections.abc import Collection

from slipscale.hardware.clock import Clock
from slipscale.hardware.contact.followed_texture import Follower, followed_texture
from slipscale.hardware.contact.source import Kind, Sample
from slipscale.hardware.driver import PlateDriver
from slipscale.stimuli.modulation import Loop
from slipscale.stimuli.surface import Surface, VirtualSurface


class Following:
    """Makes a surface's texture follow the finger if the plate supports it.

    Parameters
    ----------
    plate : PlateDriver
    clock : Clock
    sensors : collection of Kind
        Finger properties that are measured: position, force or both.
    """

    def __init__(self, plate: PlateDriver, clock: Clock, sensors: Collection[Kind] = ()) -> None:
        self._plate = plate
        self._clock = clock
        self._sensors = frozenset(sensors)
        self._surface: Surface | None = None  # while the texture follows the finger
        self._followed: Follower | None = None
        self._sensor: Kind | None = None
        self._triggers = False  # whether the finger triggers changes
        self._moved = False  # whether the level was changed after the plate had settled

    def presented_as(self, surface: Surface) -> Surface:
        """Return the surface to present first.

        If the texture follows the finger, return a constant surface at the texture's settled level.
        """
        self._followed = followed_texture(surface, self._plate, self._sensors)
        self._surface, self._moved = surface if self._followed else None, False
        self._sensor, self._triggers = surface.sensor, surface.change() is not None
        return self._settled or surface

    @property
    def _settled(self) -> VirtualSurface | None:
        surface = self._surface
        if surface is None:
            return None
        return VirtualSurface(level=surface.settled_level, label=surface.label)

    def see(self, kind: Kind, samples: list[Sample]) -> list[float] | None:
        """Set the amplitude command for the finger's current state.

        Returns
        -------
        list of float or None
            Session times at which these samples triggered a texture change; None if this sensor
            cannot trigger changes.
        """
        if self._followed is None or kind != self._sensor:
            return None
        self._followed.see(samples)
        now_s = self._clock.now()
        due = self._followed.due(now_s)
        self._moved = self._moved or due is not None
        if isinstance(due, Loop):
            self._plate.play(due)
        elif due is not None:
            self._plate.follow(due)
        started = [now_s] if isinstance(due, Loop) else []
        return started if self._triggers else None

    def settle(self) -> None:
        """Restore the texture's settled level, so that readback and command can be compared."""
        if self._surface is not None and self._moved:
            self._plate.present(self.presented_as(self._surface))
