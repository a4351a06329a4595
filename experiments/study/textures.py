"""Textures of a study: the ``[[textures]]`` tables of its file."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, model_validator

from experiments.protocols.base import Label, Positive
from faults import UserError
from stimuli.texture import Grating, Waveform


class Texture(BaseModel):
    """A grating that the study presents as one more surface.

    Parameters
    ----------
    name : str
        What the data call it.
    spatial_period_mm : float
        Length of one period.
    mean_um_pp, depth_um_pp : float
        The amplitude swings from mean - depth to mean + depth, µm peak to peak.
    waveform : {"sine", "square", "triangle", "sawtooth"}
    finger_speed_mm_s : float
        No plate tracks the finger: the texture is played as a finger of this speed would meet
        it. Stated in every study, for the data hang on it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label
    spatial_period_mm: Positive
    mean_um_pp: Positive
    depth_um_pp: Positive
    waveform: Waveform = "sine"
    finger_speed_mm_s: Positive

    @model_validator(mode="after")
    def _playable(self) -> Self:
        try:
            self.grating().loop()
        except UserError as error:
            raise ValueError(str(error)) from error
        return self

    def grating(self, label: str = "") -> Grating:
        """Return the surface, with a label that does not tell which it is."""
        return Grating(label=label, **self.model_dump())
