"""Convert between the fields of a model and the keys of its file, such as a study or plate file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from slipscale.stimuli.level_names import UNKNOWN, renamed
from slipscale.stimuli.quantity import Quantity


@dataclass(frozen=True, slots=True)
class FileNames:
    """Converter between field names and the keys used in files with levels in ``quantity``.

    Parameters
    ----------
    quantity : Quantity
    fields : frozenset of str
        Fields that contain levels.
    tables : frozenset of str
        Tables whose keys are converted, in addition to the keys at the top level.
    other : Mapping
        Quantities of tables whose levels are not in the study's quantity, keyed by table.
    """

    quantity: Quantity
    fields: frozenset[str]
    tables: frozenset[str]
    other: Mapping[str, Quantity] = field(default_factory=dict)

    def in_file(self, place: tuple[int | str, ...]) -> tuple[int | str, ...]:
        """Replace the field names in the position of an error with the keys used in the file."""
        top = place[0] if place else ""
        keys = len(place) if top in self.tables else 1
        quantity = self.quantity_in(top)
        return (
            *(
                self._key(part, quantity) if isinstance(part, str) else part
                for part in place[:keys]
            ),
            *place[keys:],
        )

    def to_code(self, table: dict[str, Any]) -> dict[str, Any]:
        """Replace the keys of a file with the field names of the model."""

        def naming(quantity: Quantity) -> Callable[[str], str]:
            # In files, names with a unit are valid keys, and field names are not.
            field_of = {field: field + UNKNOWN for field in self.fields}
            field_of |= {self._key(field, quantity): field for field in self.fields}
            return lambda key: field_of.get(key, key)

        return self._converted(table, naming)

    def to_file(self, table: dict[str, object]) -> dict[str, object]:
        """Replace field names with the keys used in the file."""
        return self._converted(table, lambda quantity: lambda key: self._key(key, quantity))

    def _converted(
        self, table: dict[str, object], naming: Callable[[Quantity], Callable[[str], str]]
    ) -> dict[str, object]:
        name = naming(self.quantity)
        return {
            name(key): renamed(value, naming(self.quantity_in(key)))
            if key in self.tables
            else value
            for key, value in table.items()
        }

    def quantity_in(self, table: int | str) -> Quantity:
        """Return the quantity used for levels in a table or in a top-level key."""
        return self.other.get(str(table), self.quantity)

    def _key(self, field: str, quantity: Quantity) -> str:
        return quantity.in_file[field] if field in self.fields else field.removesuffix(UNKNOWN)
