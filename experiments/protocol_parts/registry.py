"""Find installed protocols: the entry points in the group ``slipscale.protocols``.

Each entry point refers to a `Protocol`. The ``protocol`` key of a study file contains the entry
point's name.
"""

from __future__ import annotations

import reprlib
from dataclasses import replace

from slipscale.experiments.protocol_parts.base import Protocol
from slipscale.experiments.protocol_parts.outside import guarded
from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.plug_ins import OURS, PROTOCOLS, called, installed, package_of


def protocol_names() -> list[str]:
    """Return the names of all installed protocols, sorted."""
    return list(installed(PROTOCOLS))


def load_protocol(name: str) -> Protocol:
    """Return the installed protocol with a given name.

    Raises
    ------
    KeyError
        If no protocol with this name is installed.
    UserError
        If the entry point cannot be imported or is not a `Protocol`, or if its texts could replace
        another protocol's texts.
    """
    point = installed(PROTOCOLS)[name]
    package = package_of(point)
    named = Message("protocol '{name}' of the package {package}", name=name, package=package)
    loaded: object = called(point, point.load, named)
    if not isinstance(loaded, Protocol):
        raise UserError(
            "{protocol}: its entry point is {loaded}, expected a Protocol",
            protocol=named,
            loaded=reprlib.repr(loaded),
        )
    if package == OURS:
        return loaded
    for language, texts in loaded.texts.items():
        if foreign := [key for key in texts if not key.startswith(f"{name}.")]:
            raise UserError(
                "{protocol}: its {language} text '{foreign}' could replace another protocol's "
                "text; expected a key that begins with '{name}.'",
                protocol=named,
                language=language,
                foreign=foreign[0],
                name=name,
            )
    return guarded(replace(loaded, package=package), point)
