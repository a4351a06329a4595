"""A stimulus with one parameter as its level, as defined by ``vary`` in a study file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from slipscale.stimuli.surface import UNLISTED
from slipscale.stimuli.textures import Texture


@dataclass(frozen=True, slots=True, kw_only=True)
class Varied:
    """A stimulus at one value of the parameter that a study varies.

    Parameters
    ----------
    vary : str
        Field of the parameter.
    texture : Texture
        The stimulus; the value of that field is the level.
    """

    vary: str
    texture: Texture

    @property
    def level(self) -> float:
        """The parameter's value, in its own unit."""
        value: float = getattr(self.texture, self.vary)
        return value

    @property
    def label(self) -> str:
        """A code that does not reveal the level."""
        return self.texture.label

    @property
    def name(self) -> str:
        """Empty, because the level identifies the stimulus."""
        return ""

    @property
    def settled_level(self) -> float:
        """The level at which the plate settles before it plays, in the plate's quantity."""
        return self.texture.settled_level

    @property
    def made(self) -> Texture:
        """The surface that a plate is commanded to present."""
        return self.texture

    def at(self, level: float, label: str) -> Varied:
        """Return the stimulus at another value of the parameter, which is validated."""
        fields: dict[str, Any] = {self.vary: level, "label": label}
        return replace(self, texture=replace(self.texture, **fields))

    def turned(self, level: float) -> Varied:
        """Return the stimulus at another value, with a label that does not reveal it."""
        return self.at(level, UNLISTED)
