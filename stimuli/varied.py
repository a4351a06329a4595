"""Define stimuli whose level is the value of a parameter, selected by ``vary`` in a study file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from slipscale.stimuli.surface import UNLISTED
from slipscale.stimuli.textures import Texture


@dataclass(frozen=True, slots=True, kw_only=True)
class Varied:
    """Stimulus whose level is the value of a varied parameter.

    Parameters
    ----------
    vary : str
        Name of the field that contains the varied parameter.
    texture : Texture
        The stimulus; the field named by ``vary`` contains the level.
    """

    vary: str
    texture: Texture

    @property
    def level(self) -> float:
        """Value of the parameter, in the parameter's unit."""
        value: float = getattr(self.texture, self.vary)
        return value

    @property
    def label(self) -> str:
        """Code that does not reveal the level."""
        return self.texture.label

    @property
    def name(self) -> str:
        """Always empty, because stimuli are identified by their level."""
        return ""

    @property
    def settled_level(self) -> float:
        """Level at which the plate settles before it plays the texture, in the plate's quantity."""
        return self.texture.settled_level

    @property
    def made(self) -> Texture:
        """Surface that a plate presents."""
        return self.texture

    def at(self, level: float, label: str) -> Varied:
        """Return a validated copy of the stimulus with a different value of the parameter."""
        fields: dict[str, Any] = {self.vary: level, "label": label}
        return replace(self, texture=replace(self.texture, **fields))

    def turned(self, level: float) -> Varied:
        """Return a copy with a different value, and with a label that does not reveal the value."""
        return self.at(level, UNLISTED)
