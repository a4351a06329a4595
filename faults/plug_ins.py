"""Plug-ins: what other packages add by entry points, each name once.

Two packages that give the same name would hide one another by the accident of an installation's
order; which of them runs must not depend on that.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import TYPE_CHECKING

from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Mapping

PROTOCOLS = "slipscale.protocols"
PARTICIPANTS = "slipscale.participants"
ANALYSES = "slipscale.analyses"


@cache
def installed(group: str) -> Mapping[str, EntryPoint]:
    """Return a group's entry points by name, sorted.

    Looking through all installed packages takes some 15 ms; they do not change under a run.

    Raises
    ------
    UserError
        Two packages give the same name.
    """
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=group):
        known = found.setdefault(point.name, point)
        if known.value != point.value:
            sources = " and ".join(
                sorted(f"{each.value} ({_package(each)})" for each in (known, point))
            )
            raise UserError(
                f"plug-ins: '{point.name}' of the group {group} is there twice, as {sources}; "
                "uninstall one of the packages, or give its entry point another name"
            )
    return MappingProxyType(dict(sorted(found.items())))


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist else "no package"
