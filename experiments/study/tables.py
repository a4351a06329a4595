"""Tables of a study file other than its tasks: plate, noise, textures, cost."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from slipscale.experiments.protocols.base import Label, Positive, Seconds, Switch, Words
from slipscale.faults import UserError
from slipscale.hardware.limits import PlateLimits
from slipscale.stimuli.texture import Grating, Waveform


class MaskingNoise(BaseModel):
    """Pink noise in the headphones while the plate may be audible."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    level_db: Annotated[float, Field(strict=True, le=0, ge=-100)] = Field(
        default=-20.0,
        description="Level relative to full scale.",
        json_schema_extra={"unit": "dB re full scale"},
    )
    fade_s: Seconds = Field(default=0.5, description="Fading in and fading out, each.")
    required: Switch = Field(
        default=False, description="Whether a session without an audio device is refused."
    )


Amount = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]


class Cost(BaseModel):
    """The costs of the study, for ``slipscale study show --timeline``."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    currency: Words = Field(default="EUR", description="The currency's name, as it is printed.")
    per_person: Amount = Field(
        default=0.0,
        description="What each participant is paid.",
        json_schema_extra={"unit": "currency"},
    )
    per_rig_hour: Amount = Field(
        default=0.0,
        description="What an hour at the rig costs, experimenter included.",
        json_schema_extra={"unit": "currency an hour"},
    )
    setup_minutes: Amount = Field(
        default=0.0,
        description="Time at the rig before and after each run: greeting, cleaning, paying.",
        json_schema_extra={"unit": "minutes a run"},
    )


class PlateSettings(BaseModel):
    """The plate of a study, and limits that differ from the shipped ones."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    file: str = Field(
        default="",
        description="A plate's own file, or its name in the folder plates; a session with a "
        "person, and its check, are refused on another one.",
    )
    level: Positive = Field(
        default=PlateLimits().level,
        description="Largest amplitude that may be presented; a larger one in the study is a "
        "fault, and the plate is never asked for it.",
    )
    tolerance: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = Field(
        default=None,
        description="How far a measured amplitude may lie from the one commanded, as a share of "
        "it; left out: as far as the plate's own limits allow. A narrower one than these is held "
        "to, a wider one is not.",
        json_schema_extra={"unit": "share, 0 to 1"},
    )
    tolerance_level: Positive | None = Field(
        default=None,
        description="The same as an amplitude; the larger of the two counts. A study of thresholds "
        "needs a plate that holds an amplitude better than its finest difference.",
    )
    track_resonance: str = Field(
        default="",
        description="SPEC of a vibrometer, vibrometer:PORT: a generator's or a sound card's "
        "resonance is looked for again before a trial, at three frequencies; left out: it is "
        "driven where the calibration says. A driver board follows its resonance by itself.",
    )
    track_every_s: Positive = Field(
        default=120.0, description="The least time between two such sweeps."
    )
    position: str = Field(
        default="",
        description="SPEC of what tells where the finger is, such as lasers:/dev/ttyUSB1; left "
        "out: its place is not measured. A pilot simulates it; `--position` overrides it.",
    )
    force: str = Field(
        default="",
        description="SPEC of what measures normal and lateral force, such as "
        "load_cells:/dev/ttyUSB2; left out: forces are not measured. A pilot simulates them; "
        "`--force` overrides it.",
    )


# No plate is a metre long, so a longer period would exceed any stroke.
LONGEST_MM = 1000.0


class Texture(BaseModel):
    """A grating that the study presents as an additional surface."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label = Field(description="What the data call the texture: letters, digits and _.")
    spatial_period_mm: Annotated[Positive, Field(le=LONGEST_MM)] = Field(
        description="Length of one period."
    )
    mean_level: Positive = Field(description="Mean of the vibration amplitude over a period.")
    depth_level: Positive = Field(
        description="The amplitude swings from mean - depth to mean + depth."
    )
    waveform: Waveform = Field(default="sine", description="Form of the amplitude over one period.")
    finger_speed_mm_s: Positive = Field(
        description="Speed of the finger for which the texture is played where nothing tells the "
        "finger's place. Every study states it, since the data depend on it."
    )

    @model_validator(mode="after")
    def _playable(self) -> Self:
        try:
            self.grating().loop()
        except UserError as error:
            raise ValueError(str(error)) from error
        return self

    def grating(self, label: str = "") -> Grating:
        """Return the texture as a surface, with a label that does not identify it."""
        return Grating(label=label, **self.model_dump())
