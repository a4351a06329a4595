"""Sounds that belong to a question, as the session knows them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from slipscale.stimuli.headphone_sounds import HeadphoneSound


class Sounds(Protocol):
    """Plays sounds in the headphones."""

    @property
    def missing(self) -> str:
        """Why there is nothing to hear; empty where there is."""

    def start(self, sound: HeadphoneSound) -> None:
        """Begin to play; a sound that plays already is broken off."""

    def stop(self) -> None:
        """Break off what plays."""


class NoSounds:
    """Nothing can be heard."""

    def __init__(self, missing: str) -> None:
        self.missing = missing

    def start(self, sound: HeadphoneSound) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""


class ImaginedSounds(NoSounds):
    """What simulated people hear: they know the sound itself."""

    def __init__(self) -> None:
        super().__init__("")
