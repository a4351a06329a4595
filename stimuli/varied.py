"""Define stimuli whose level is a parameter's value, for ``vary`` in study files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from slipscale.stimuli.surface import UNLISTED
from slipscale.stimuli.textures import Texture


@dataclass(frozen=True, slots=True, kw_only=True)
class Varied:
    """Stimulus with one value of the varied parameter.

    Parameters
    ----------
    vary : str
        Name of the field that contains the varied parameter.
    texture : Texture
        Stimulus. The value of its field ``vary`` is the level.
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
        """Empty, because the level identifies the stimulus."""
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
        """Return the stimulus at another value of the parameter, after validation."""
        fields: dict[str, Any] = {self.vary: level, "label": label}
        return replace(self, texture=replace(self.texture, **fields))

    def turned(self, level: float) -> Varied:
        """Return the stimulus with another value and a label that does not reveal the value."""
        return self.at(level, UNLISTED)
