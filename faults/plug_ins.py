"""Plug-ins: what other packages add by entry points, each name once.

Two packages that give the same name would hide one another by the accident of an installation's
order; which of them runs must not depend on that. What goes wrong in a package is told in one
sentence that names it.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeVar

from slipscale.faults import RigError, UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

PROTOCOLS = "slipscale.protocols"
PARTICIPANTS = "slipscale.participants"
ANALYSES = "slipscale.analyses"
OURS = "slipscale"

T = TypeVar("T")


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
                sorted(f"{each.value} ({package_of(each)})" for each in (known, point))
            )
            raise UserError(
                f"plug-ins: '{point.name}' of the group {group} is there twice, as {sources}; "
                "uninstall one of the packages, or give its entry point another name"
            )
    return MappingProxyType(dict(sorted(found.items())))


@cache
def package_of(point: EntryPoint) -> str:
    """Return the name of the package that brings a plug-in.

    Its description is a file that takes 2 ms to read, and every run asks for each of its protocols.
    """
    return point.dist.name if point.dist else "no package"


def called(point: EntryPoint, action: Callable[[], T], what: str) -> T:
    """Return what a plug-in's own code returns; tell in one sentence what it raises.

    Parameters
    ----------
    point : EntryPoint
    action : callable
        Calls the plug-in.
    what : str
        The subject of the sentence: "analysis 'grip' of the package ourlab".

    Raises
    ------
    UserError
        The plug-in raised something other than a sentence of its own; the line is that of the
        innermost of its own functions.
    """
    try:
        return action()
    except (UserError, RigError):
        raise
    except Exception as error:
        raise UserError(f"{what} raised {_told(point, error)}") from error


def _told(point: EntryPoint, error: Exception) -> str:
    own, line = point.module.partition(".")[0], ""
    trace = error.__traceback__
    while trace:
        module = str(trace.tb_frame.f_globals.get("__name__"))
        if module.partition(".")[0] == own:
            line = f" (module {module}, line {trace.tb_lineno})"
        trace = trace.tb_next
    words = " ".join(str(error).split())
    return f"{type(error).__name__}{f': {words}' if words else ''}{line}"
