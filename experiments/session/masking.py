"""Masking noise as the session knows it; `experiments.session.masking_output` plays it."""

from __future__ import annotations

from typing import Literal, Protocol

NoiseState = Literal["absent", "silent", "playing"]


class Noise(Protocol):
    """Masking noise in the headphones."""

    @property
    def state(self) -> NoiseState:
        """Whether it plays now."""

    def start(self) -> None:
        """Fade in, unless it plays; return once it is at its level."""

    def stop(self) -> None:
        """Fade out, if it plays."""


class NoNoise:
    """No masking noise."""

    state: NoiseState = "absent"

    def start(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""
