"""Masking noise as the session knows it; `experiments.session.masking_output` plays it."""

from __future__ import annotations

from typing import Protocol


class Noise(Protocol):
    """Masking noise in the headphones."""

    def start(self) -> None:
        """Fade in, unless it plays."""

    def stop(self) -> None:
        """Fade out, if it plays."""


class NoNoise:
    """No masking noise."""

    def start(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""
