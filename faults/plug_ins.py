"""Find plug-ins that other packages provide as entry points.

Names must be unique, because otherwise the order of installation would determine which plug-in is
used. Errors in a plug-in are reported in one sentence that names the package.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import TypeVar

from slipscale.faults import RigError, UserError

PROTOCOLS = "slipscale.protocols"
QUESTIONS = "slipscale.questions"
PARTICIPANTS = "slipscale.participants"
ANALYSES = "slipscale.analyses"
OURS = "slipscale"
#: Names of plug-ins are written in study files, and parts of column names and file names.
NAMES = re.compile("[a-z][a-z0-9_]*")

T = TypeVar("T")


@cache
def installed(group: str) -> Mapping[str, EntryPoint]:
    """Return the entry points in a group, sorted by name.

    Raises
    ------
    UserError
        If two packages provide plug-ins with the same name, if a name contains other characters
        than lower-case letters, digits and underscores, or if Slipscale's own are missing.
    """
    found: dict[str, EntryPoint] = {}
    points = entry_points(group=group)
    if not points and group in (PROTOCOLS, QUESTIONS):
        raise UserError(
            "this installation of Slipscale is incomplete: the group of entry points {group} is "
            "empty; install Slipscale again",
            group=group,
        )
    for point in points:
        if not NAMES.fullmatch(point.name):
            raise UserError(
                "plug-ins: the name '{point_name}' in the group {group} (package {package}); "
                "expected lower-case letters, digits and underscores; rename the entry point",
                point_name=point.name,
                group=group,
                package=package_of(point),
            )
        known = found.setdefault(point.name, point)
        if (known.value, package_of(known)) != (point.value, package_of(point)):
            sources = " and ".join(
                sorted(f"{each.value} ({package_of(each)})" for each in (known, point))
            )
            raise UserError(
                "plug-ins: both {sources} provide '{point_name}' in the group {group}; uninstall "
                "one of the packages, or rename an entry point",
                sources=sources,
                point_name=point.name,
                group=group,
            )
    return MappingProxyType(dict(sorted(found.items())))


@cache
def package_of(point: EntryPoint) -> str:
    """Return the name of the package that provides a plug-in."""
    return point.dist.name if point.dist else "no package"


def called(point: EntryPoint, action: Callable[[], T], what: str) -> T:
    """Call a plug-in, and raise a UserError with a one-sentence message if it fails.

    Parameters
    ----------
    point : EntryPoint
    action : callable
        Function without parameters that calls the plug-in.
    what : str
        Subject of the sentence, such as "analysis 'grip' of the package ourlab".

    Raises
    ------
    UserError
        If the plug-in raises an exception other than a UserError or a RigError. The message gives
        the line of the plug-in's code.
    """
    try:
        return action()
    except (UserError, RigError):
        raise
    except Exception as error:
        raise UserError("{what} raised {told}", what=what, told=_told(point, error)) from error


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
