"""Define tables of a study file, such as plate, masking noise, textures and costs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import fields
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, create_model, model_validator

from slipscale.experiments.protocol_parts.base import Label, Positive, Seconds, Switch, Words
from slipscale.faults import UserError
from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.faults.message import Message
from slipscale.faults.validation import Fault, refuse
from slipscale.hardware.limits import PlateLimits
from slipscale.stimuli.parameters import Parameter, declared
from slipscale.stimuli.quantity_table import QuantityTable
from slipscale.stimuli.textures import KINDS, PARAMETERS
from slipscale.stimuli.textures import Texture as TextureSurface
from slipscale.stimuli.transient import Shape
from slipscale.stimuli.varied import Varied
from slipscale.stimuli.waves import Waveform


class MaskingNoise(FrozenTable):
    """Pink noise in the headphones while the plate may be audible."""

    level_db: Annotated[float, Field(strict=True, le=0, ge=-100)] = setting(
        -20.0, "Level relative to full scale.", unit="dB re full scale"
    )
    fade_s: Seconds = setting(0.5, "Duration of the fade-in and of the fade-out.")
    required: Switch = setting(False, "Whether a session requires an audio device.")


Kind = Literal["grating", "transient", "map"]
Amount = Annotated[float, Field(strict=True, ge=0, allow_inf_nan=False)]


class Cost(FrozenTable):
    """The costs of the study, for ``slipscale study show --timeline``."""

    currency: Words = setting("EUR", "Name of the currency, as printed.")
    per_person: Amount = setting(0.0, "Payment per participant.", unit="currency")
    per_rig_hour: Amount = setting(
        0.0, "Cost of an hour at the rig, including the experimenter.", unit="currency per hour"
    )
    setup_minutes: Amount = setting(
        0.0,
        "Time at the rig before and after each run, for welcoming, cleaning and payment.",
        unit="minutes per run",
    )


class Simulated(FrozenTable):
    """How the sensation of simulated people grows with the level."""

    weber: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = setting(
        None,
        "Smallest change, as a proportion of the level, that is detected in 75 % of forced "
        "choices; the sensation grows with the logarithm of the level.",
        unit="share, 0 to 1",
    )
    exponent: Annotated[float, Field(strict=True, gt=0, allow_inf_nan=False)] = setting(
        1.0,
        "Exponent of the power function from level to sensation if weber is not set. The level is "
        "expressed as its position in the study's range, from 0 to 1.",
        unit="none",
    )


class PlateSettings(FrozenTable):
    """Settings of the plate that a study uses."""

    file: str = setting(
        "",
        "Path of a plate file, or name of a plate in the plates folder. Sessions with "
        "participants, and the checks before them, are rejected on any other plate.",
    )
    level: Positive = setting(
        PlateLimits().level,
        "Largest amplitude that may be presented. A study with a larger amplitude is rejected.",
    )
    tolerance: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = setting(
        None,
        "Largest accepted difference between measured and commanded amplitude, as a fraction of "
        "the commanded amplitude; default: the plate's own limit. A value above the plate's own "
        "limit is ignored.",
        unit="share, 0 to 1",
    )
    tolerance_level: Positive | None = setting(
        None,
        "Largest accepted difference between measured and commanded amplitude, in the amplitude's "
        "unit. The larger of this tolerance and `tolerance` applies. In a threshold study, the "
        "plate's tolerance must be smaller than the study's finest difference.",
    )
    track_resonance: str = setting(
        "",
        "SPEC of a vibrometer (vibrometer:PORT), which measures the plate's resonance at three "
        "frequencies before a trial if a generator or sound card drives the plate; by default, "
        "the calibrated frequency is used. A driver board tracks its resonance automatically.",
    )
    track_every_s: Positive = setting(
        120.0, "Shortest time between two measurements of the resonance."
    )
    position: str = setting(
        "",
        "SPEC of the finger-position sensor, such as lasers:/dev/ttyUSB1; default: the position "
        "is not measured. Pilots simulate the sensor; the command-line option `--position` "
        "overrides this key.",
    )
    force: str = setting(
        "",
        "SPEC of the sensor for normal and lateral force, such as load_cells:/dev/ttyUSB2; "
        "default: forces are not measured. Pilots simulate the sensor; the command-line option "
        "`--force` overrides this key.",
    )


class SecondPlate(FrozenTable):
    """A second actuator on the plate, driven together with every surface."""

    quantity: QuantityTable = Field(description="Quantity of the second actuator's levels.")
    level: Positive = Field(
        description="Largest level of the second actuator. A factor whose name is this key with "
        "the prefix `second_`, such as second_voltage_v_peak, sets the level in each condition.",
    )

    @property
    def factor(self) -> str:
        """The name of the factor that sets the level."""
        return f"second_{self.quantity.quantity.named('level')}"


class StatedWords(FrozenTable):
    """Words for an attribute in one language."""

    adjective: Words = Field(
        description=(
            "Adjective, as in “How slippery is it?”, in the feminine form if the "
            "language has genders."
        )
    )
    noun: Words = Field(description="Noun, as in “slipperiness”.")
    masculine: str = setting("", "The adjective's masculine form.")
    plural: str = setting("", "The adjective's plural.")


def _field(parameter: Parameter) -> object:
    """Return a field that checks the range of a parameter."""
    bounds: dict[str, Any] = {"gt": parameter.above, "ge": parameter.least, "le": parameter.most}
    return Field(
        default=None,
        strict=True,
        allow_inf_nan=False,
        description=parameter.description,
        **{name: bound for name, bound in bounds.items() if math.isfinite(bound)},
    )


if TYPE_CHECKING:
    _Parameters = FrozenTable
else:
    _Parameters = create_model(
        "_Parameters",
        __base__=FrozenTable,
        **{field: (each.kind | None, _field(each.parameter)) for field, each in PARAMETERS.items()},
    )


class StimulusTable(_Parameters):
    """Fixed parameters of the stimulus, in a study that varies another parameter."""

    kind: Kind = setting(
        "grating",
        "Kind of texture. grating: a wave along the stroke or in time. transient: one change at "
        "a position, a force or a time after contact. map: the grey values of an image.",
    )
    waveform: Waveform | None = setting(None, "Shape of a grating over one period; default: sine.")
    shape: Shape | None = setting(None, "Shape of a transient's transition; default: cosine.")

    image: str | None = setting(
        None,
        "For a map, the name of a greyscale PNG file in the study file's folder. The image has one "
        "or more rows of pixels along the stroke.",
    )
    pixels: str | None = setting(
        None, "Content of the image; Slipscale inserts this key when it reads the study."
    )
    columns: int | None = setting(
        None,
        "Number of pixels per row of the image; Slipscale inserts this key when it reads the "
        "study.",
        unit="pixels",
    )

    @property
    def _given(self) -> dict[str, Any]:
        return self.model_dump(exclude_none=True, exclude={"kind"})

    def faults(self, vary: str = "") -> Iterator[Fault]:
        """Yield an error for each missing or superfluous parameter."""
        kind = KINDS[self.kind]
        given = {*self._given, vary} - {""}
        in_time = {"finger_speed_mm_s"} if "modulation_hz" in given else set()
        for field, each in declared(kind).items():
            if each.stated and field not in given | in_time:
                yield (field,), {"msg": "is missing"}
        if "pixels" not in given and self.kind == "map":
            yield ("image",), {"msg": "is missing"}
        for field in sorted(given - {each.name for each in fields(kind)}):
            if field == vary:
                yield (
                    ("kind",),
                    {
                        "msg": Message(
                            "a {kind} does not have the parameter to vary", kind=self.kind
                        )
                    },
                )
            else:
                yield (field,), {"msg": Message("does not belong to a {kind}", kind=self.kind)}
        if vary in self._given:
            yield (vary,), {"msg": "is varied and must be omitted"}

    def varied(self, vary: str, level: float) -> Varied:
        """Return the stimulus with the varied parameter at a given level.

        Raises
        ------
        UserError
            If a parameter is out of range.
        """
        given = self._given | {vary: level}
        return Varied(vary=vary, texture=KINDS[self.kind](name="stimulus", **given))


class Texture(StimulusTable):
    """A texture that the study presents in addition to plain surfaces."""

    name: Label = Field(description="Name of the texture in the data: letters, digits and _.")

    @model_validator(mode="after")
    def _playable(self) -> Self:
        refuse(self.faults(), within=True)
        try:
            self.surface().loop()
        except UserError as error:
            raise ValueError(str(error)) from error
        return self

    def surface(self, label: str = "") -> TextureSurface:
        """Return a surface that presents the texture; ``label`` must not reveal the texture."""
        return KINDS[self.kind](label=label, **self._given)
