"""Find installed position and force sensors through their entry points.

The SPEC is ``NAME`` or ``NAME:ADDRESS``; ``none`` means no sensor.
"""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Protocol

from slipscale.faults import UserError
from slipscale.hardware.contact.source import ContactSource, Kind, Surroundings

NONE = "none"
GROUPS: dict[Kind, str] = {"position": "slipscale.positions", "force": "slipscale.forces"}


class SourceFactory(Protocol):
    """Interface for entry points that create sources of position or force."""

    def __call__(self, address: str, surroundings: Surroundings) -> ContactSource:
        """Return an unconnected source; ``address`` is the part of the SPEC after the colon."""


def open_source(kind: Kind, spec: str, surroundings: Surroundings) -> ContactSource:
    """Return the source named in a SPEC, not yet connected.

    Raises
    ------
    UserError
        If no source with this name is installed, or if its address is invalid.
    """
    name, _, address = spec.partition(":")
    found = {point.name: point for point in entry_points(group=GROUPS[kind])}
    if name not in found:
        known = ", ".join([*sorted(found), NONE])
        raise UserError(
            "--{kind} '{spec}': unknown source '{name}'; expected one of {known}",
            kind=kind,
            spec=spec,
            name=name,
            known=known,
        )
    factory: SourceFactory = found[name].load()
    return factory(address, surroundings)
