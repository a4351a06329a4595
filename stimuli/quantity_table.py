"""Define the table ``[quantity]`` of study files and plate files."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, ValidationError

from slipscale.faults.frozen_table import FrozenTable, setting
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity, made_by_plate

Text = Annotated[str, Field(strict=True, min_length=1)]


class QuantityTable(FrozenTable):
    """Quantity that the plate produces and in which levels are given."""

    name: Annotated[str, Field(strict=True, pattern=r"^[a-z]+( [a-z]+)*$")] = setting(
        PLATE_AMPLITUDE.name, "Name of the quantity, a lower-case noun such as voltage."
    )
    unit: Text = setting(PLATE_AMPLITUDE.unit, "Symbol of the unit, such as V, m/s² or N.")
    convention: Literal["peak to peak", "peak", "RMS", ""] = setting(
        "peak to peak", "Convention that the unit does not express, such as RMS; may be empty."
    )
    judged: Text = setting(
        PLATE_AMPLITUDE.judged, "Attribute that participants judge: a noun such as roughness."
    )
    falls: Annotated[bool, Field(strict=True)] = setting(
        False, "Whether the judged attribute decreases as the quantity increases."
    )

    @classmethod
    def stating(cls, quantity: Quantity) -> QuantityTable:
        """Create the table that describes a quantity."""
        return cls.model_validate({name: getattr(quantity, name) for name in cls.model_fields})

    @property
    def quantity(self) -> Quantity:
        """Quantity described by the table."""
        return made_by_plate(self.name, self.unit, self.convention, self.judged, falls=self.falls)


def stated_quantity(table: dict[str, object]) -> Quantity:
    """Return the quantity stated in a file, before the file is validated.

    If ``[quantity]`` is invalid, the plate's amplitude is returned. The error is reported later,
    when the file is validated.
    """
    try:
        return QuantityTable.model_validate(table.get("quantity", {})).quantity
    except ValidationError:
        return PLATE_AMPLITUDE
