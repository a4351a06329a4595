"""Plug-ins that other packages add as entry points; each name must be unique.

If two packages used the same name, the order of installation would determine which of them runs.
Errors in a package are reported in one sentence that names the package.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import TypeVar

from slipscale.faults import RigError, UserError

PROTOCOLS = "slipscale.protocols"
PARTICIPANTS = "slipscale.participants"
ANALYSES = "slipscale.analyses"
OURS = "slipscale"

T = TypeVar("T")


@cache
def installed(group: str) -> Mapping[str, EntryPoint]:
    """Return a group's entry points by name, sorted.

    Cached: a search of all installed packages takes about 15 ms, and they do not change during a
    run.

    Raises
    ------
    UserError
        If two packages use the same name.
    """
    found: dict[str, EntryPoint] = {}
    for point in entry_points(group=group):
        known = found.setdefault(point.name, point)
        if known.value != point.value:
            sources = " and ".join(
                sorted(f"{each.value} ({package_of(each)})" for each in (known, point))
            )
            raise UserError(
                f"plug-ins: '{point.name}' of the group {group} is provided by both "
                f"{sources}; uninstall one of the packages, or give its entry point another "
                "name"
            )
    return MappingProxyType(dict(sorted(found.items())))


@cache
def package_of(point: EntryPoint) -> str:
    """Return the name of the package that provides a plug-in.

    Cached: reading its metadata file takes 2 ms, and every run queries each of its protocols.
    """
    return point.dist.name if point.dist else "no package"


def called(point: EntryPoint, action: Callable[[], T], what: str) -> T:
    """Return the result of a plug-in's own code; report its exceptions in one sentence.

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
        If the plug-in raised an exception other than a UserError. The message contains the line of
        the innermost of its own functions.
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
