"""Declare the stimulus parameters that a study can vary.

A field of a texture (`slipscale.stimuli.textures`) can be the level of a protocol (``vary`` in a
study file) if its type annotation contains a `Parameter`. The declaration defines the key and range
in the study file, and the column and unit in the data.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cache
from typing import Self, get_type_hints

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.stimuli.quantity import Quantity, made_by_plate


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """Declaration of a numerical parameter of a stimulus.

    Parameters
    ----------
    name : str
        Noun phrase; the placeholder ``{q.name}`` is replaced with the plate's quantity.
    description : str
        Meaning, as printed in the reference for study files.
    unit : str or None
        Unit; None for the plate's unit.
    above, least, most : float
        Limits: a value must be greater than ``above``, at least ``least`` and at most ``most``.
    stated : bool
        Whether every study must set the value, even if the field has a default.
    """

    name: str
    description: str
    unit: str | None
    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    stated: bool = False

    @property
    def range(self) -> str:
        """Description of the range."""
        parts = [f"above {self.above:g}"] if self.above > -math.inf else []
        parts += [Message("{least:g} or more", least=self.least)] if self.least > -math.inf else []
        parts += [Message("at most {most:g}", most=self.most)] if self.most < math.inf else []
        return ", ".join(parts)

    def refuse(self, where: str, field: str, value: float) -> None:
        """Raise `UserError` if a value is out of range; ``where`` describes the stimulus."""
        within = self.above < value <= self.most and value >= self.least
        if not (math.isfinite(value) and within):
            key = (
                self.name.removesuffix(" {q.name}").replace(" ", "_")
                if self.unit is None
                else field
            )
            unit = f" {self.unit}" if self.unit else ""
            raise UserError(
                "{where}: {key} is {value}, expected {range}{unit}",
                where=where,
                key=key,
                value=value,
                range=self.range,
                unit=unit,
            )

    def quantity(self, plate: Quantity) -> Quantity:
        """Return the quantity whose levels are values of this parameter."""
        unit, convention = plate.unit, plate.convention
        if self.unit is not None:
            unit, convention = self.unit, ""
        name = self.name.format(q=plate)
        return made_by_plate(name, unit, convention, plate.judged, falls=plate.falls)


#: Parameter of all textures that can be played without a sensor.
FINGER_SPEED = Parameter(
    name="finger speed",
    unit="mm/s",
    above=0,
    description="Finger speed at which the texture is played if the finger's position is not "
    "measured. Required in every study, because the data depend on the speed.",
    stated=True,
)


@dataclass(frozen=True, slots=True)
class Declared:
    """Parameter that a stimulus declares, with its type and default value."""

    parameter: Parameter
    kind: object
    default: object
    stated: bool


def declared(stimulus: type) -> Mapping[str, Declared]:
    """Return the parameters that a stimulus class declares, keyed by field name."""
    return _declared(stimulus)


@cache
def _declared(stimulus: type) -> Mapping[str, Declared]:
    hints, found = get_type_hints(stimulus, include_extras=True), {}
    for each in fields(stimulus):
        for parameter in getattr(hints[each.name], "__metadata__", ()):
            if isinstance(parameter, Parameter):
                stated = parameter.stated or each.default is MISSING
                default = None if stated else each.default
                found[each.name] = Declared(parameter, hints[each.name].__origin__, default, stated)
    return found


class Parametric:
    """Base class of stimuli with parameters that a study can vary."""

    __slots__ = ()
    label: str
    name: str

    @property
    def where(self) -> str:
        """Name by which messages refer to the texture."""
        return f"texture '{self.name or self.label}'"

    @property
    def made(self) -> Self:
        """Surface that a plate presents for this stimulus: the texture itself."""
        return self

    def turned(self, level: float) -> Self:
        """Raise ValueError, because a texture has no single level that can be adjusted."""
        raise ValueError(
            Message("{where} cannot be adjusted to {level}", where=self.where, level=level)
        )

    def refuse_parameters(self) -> None:
        """Raise `UserError` if a parameter is out of range."""
        for field, each in declared(type(self)).items():
            if (value := getattr(self, field)) is not None:
                each.parameter.refuse(self.where, field, value)


def field_of(key: str, plate: Quantity, known: Mapping[str, Declared]) -> str | None:
    """Return the field for a key in a study file, or None if the key is not a parameter."""
    return next((field for field in known if plate.named(field) == key), None)
