"""The small tables of a study file, each on its own: plate, masking noise, questions."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, field_validator

from experiments.languages.texts import FEWEST_ANSWERS, NUMBER_KEYS
from experiments.protocols.base import Flag, Label, Positive, Seconds, Words
from hardware.limits import PlateLimits

# Columns of participants.tsv that Slipscale fills itself.
TAKEN = ("participant_id", "mode", "complete")


class PersonQuestion(BaseModel):
    """A question about the participant, with given answers; names are never asked for.

    ``prompt`` defaults to the shipped text ``about_you.<name>``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: Label
    options: Annotated[tuple[Words, ...], Field(min_length=FEWEST_ANSWERS, max_length=NUMBER_KEYS)]
    prompt: str = ""

    @field_validator("options")
    @classmethod
    def _distinct(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) < len(value):
            raise ValueError("expected options that are all different")
        return value

    @field_validator("name")
    @classmethod
    def _free(cls, value: str) -> str:
        if value in TAKEN:
            raise ValueError("expected another name: this one is a column already")
        return value


class MaskingNoise(BaseModel):
    """Pink noise in the headphones while the plate may sound."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    level_db: Annotated[float, Field(strict=True, le=0, ge=-100)] = -20.0
    fade_s: Seconds = 0.5
    required: Flag = False


class PlateSettings(BaseModel):
    """The plate's limits, where they differ from the shipped ones."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    amplitude_um_pp: Positive = PlateLimits().amplitude_um_pp
