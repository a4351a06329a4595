"""Interpret a study's levels, and check whether they can be presented.

A level is a value of the quantity that the plate produces, or of the varied ``[stimulus]``
parameter. A level can be presented if it is in range and does not exceed the plate's limit, and if
the plate, the serial line and the air film respond fast enough
(`slipscale.stimuli.modulation.LEAST_FOLLOWED`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from slipscale.experiments.protocol_parts.base import Context
from slipscale.experiments.study.tables import PlateSettings, StimulusTable
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.toml_lines import Place
from slipscale.faults.validation import Fault
from slipscale.stimuli.level_names import is_level
from slipscale.stimuli.modulation import FILM_TIME_CONSTANT_S, LEAST_FOLLOWED
from slipscale.stimuli.parameters import field_of
from slipscale.stimuli.quantity import Quantity
from slipscale.stimuli.quantity_table import QuantityTable
from slipscale.stimuli.surface import Stimulus, VirtualSurface
from slipscale.stimuli.textures import PARAMETERS, Texture
from slipscale.stimuli.varied import Varied


@dataclass(frozen=True, slots=True, kw_only=True)
class Levels:
    """Meaning of a study's levels: the plate's quantity or a parameter of the stimulus.

    Parameters
    ----------
    made : Quantity
        The quantity that the plate produces, such as its vibration amplitude.
    limit_level : float
        The largest value that the plate may produce.
    vary : str
        Field of the varied parameter; empty if no parameter is varied.
    stimulus : StimulusTable or None
        The stimulus's fixed parameters.
    """

    made: Quantity
    limit_level: float
    vary: str = ""
    stimulus: StimulusTable | None = None

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> Levels:
        """Interpret the levels of a study, given its valid fields."""
        table: QuantityTable = fields.get("made", QuantityTable())
        if attribute := fields.get("attribute"):
            table = table.model_copy(update={"judged": attribute})
        if fields.get("attribute_falls"):
            table = table.model_copy(update={"falls": True})
        plate: PlateSettings | None = fields.get("plate")
        return cls(
            made=table.quantity,
            limit_level=plate.level if plate else math.inf,
            vary=field_of(fields.get("vary", ""), table.quantity, PARAMETERS) or "",
            stimulus=fields.get("stimulus"),
        )

    @classmethod
    def stated(cls, content: Mapping[str, Any]) -> Levels:
        """Interpret the levels of a study file. Raises `ValueError` for invalid tables."""
        stimulus = content.get("stimulus")
        return cls.of(
            {
                "made": QuantityTable.model_validate(content.get("quantity", {})),
                "vary": content.get("vary", ""),
                "stimulus": stimulus and StimulusTable.model_validate(stimulus),
            }
        )

    @property
    def quantity(self) -> Quantity:
        """Quantity in which levels are given: the varied parameter or, by default, the plate's."""
        return PARAMETERS[self.vary].parameter.quantity(self.made) if self.vary else self.made

    def varied(self, levels: tuple[float, ...]) -> Varied | None:
        """Return the varied stimulus at the first level; None if the study has no such stimulus."""
        if not (self.vary and self.stimulus and levels):
            return None
        return self.stimulus.varied(self.vary, levels[0])

    def context(
        self, levels: tuple[float, ...], textures: tuple[Texture, ...] = (), task: str = ""
    ) -> Context:
        """Return a context without a participant, used to check what a protocol would present."""
        return Context(
            seed=0,
            participant="",
            row=0,
            levels=levels,
            quantity=self.quantity,
            texts={},
            task=task,
            textures=textures,
            varied=self.varied(levels),
        )

    def surface(self, level: float) -> Stimulus | None:
        """Return the surface for a level.

        Return None if a parameter is varied, but ``[stimulus]`` is missing.

        Raises
        ------
        UserError
            If the level or a parameter of ``[stimulus]`` is out of range.
        """
        return self.varied((level,)) if self.vary else VirtualSurface(level=level)

    def beyond(self, place: Place, *surfaces: Stimulus) -> Iterator[Fault]:
        """Yield one error that lists all levels above the plate's limit."""
        levels = dict.fromkeys(each.made.level for each in surfaces)
        if beyond := ", ".join(str(each) for each in levels if each > self.limit_level):
            limit = f"{self.limit_level} {self.made.unit_in_short}"
            yield (
                place,
                {
                    "msg": Message(
                        "{beyond} is beyond the plate's {limit}", beyond=beyond, limit=limit
                    )
                },
            )

    def unpresentable(self, place: Place, *levels: float) -> Iterator[Fault]:
        """Yield errors that state which levels cannot be presented, and why."""
        possible = []
        for level in levels:
            try:
                surface = self.surface(level)
                if surface is None:
                    return  # another check reports the error in [stimulus]
                self.follow(surface)
            except UserError as error:
                yield place, {"msg": str(error)}
            else:
                possible.append(surface)
        yield from self.beyond(place, *possible)

    def follow(self, surface: Stimulus) -> None:
        """Raise `UserError` if the plate, the serial line or the air film responds too slowly."""
        surface.made.loop()
        followed = surface.made.followed()
        if followed and not followed.felt and self.made.in_um_pp:
            film_ms = 1000 * FILM_TIME_CONSTANT_S
            raise UserError(
                "{level} corresponds to {change}, at which friction reproduces only "
                "{friction:.1%} of {whole} (film {film_ms:g} ms); expected at least "
                "{least_followed:.0%}. Use {remedy}",
                level=self.quantity.short(surface.level),
                change=followed.change,
                friction=followed.friction,
                whole=followed.whole,
                film_ms=film_ms,
                least_followed=LEAST_FOLLOWED,
                remedy=followed.remedy,
            )

    def unstated(self, place: Place, table: BaseModel) -> Iterator[Fault]:
        """Yield an error for each omitted key whose default, in µm, does not fit the quantity."""
        quantity = self.made if place[0] == "plate" else self.quantity
        if quantity.in_um_pp:
            return
        for key, field in type(table).model_fields.items():
            left_out = is_level(key) and key not in table.model_fields_set
            if left_out and field.default is not None:
                unit = quantity.unit_in_full
                message = Message(
                    "is missing; expected a value in {unit}, because the default is in µm",
                    unit=unit,
                )
                yield (*place, key), {"msg": message}
