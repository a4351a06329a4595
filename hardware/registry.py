"""Find installed backends by their entry points."""

from __future__ import annotations

import logging
import re
from functools import cache
from importlib.metadata import EntryPoints, entry_points
from typing import TYPE_CHECKING, Protocol

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.faults.suggestions import expected_one_of
from slipscale.hardware.address import PAIR
from slipscale.hardware.output.unattended import Unguarded

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.driver import PlateDriver

LOG = logging.getLogger(__name__)
BACKENDS = "slipscale.backends"  # the entry-point group
INTERLOCK = "interlock="  # option of every SPEC except a pair's
PORT = re.compile(r"(/dev/)?(tty\w|cu\.)|/dev/|COM\d", re.IGNORECASE)  # a SPEC without a backend


class Backend(Protocol):
    """Interface for entry points in the group ``slipscale.backends``, which create drivers."""

    def __call__(self, address: str, *, clock: Clock, seed: int) -> PlateDriver:
        """Return a driver that is not yet connected.

        Parameters
        ----------
        address : str
            Part of the plate's SPEC after the colon: a port, a VISA resource, or "".
        clock : Clock
            Clock of the session.
        seed : int
            Random seed for simulated backends.
        """


@cache
def _installed() -> EntryPoints:
    # Cached, because searching all installed packages takes about 15 ms.
    return entry_points(group=BACKENDS)


def backend_names() -> list[str]:
    """Return the names of all installed backends, sorted."""
    return sorted(_installed().names)


def unknown_backend(spec: str) -> str:
    """Return the error message for an unknown backend in a SPEC.

    >>> unknown_backend("ttyACM0")
    "unknown backend 'ttyACM0'; to use a port, name its backend: serial:/dev/ttyACM0"
    """
    name = spec.partition(":")[0]
    port = PORT.match(spec)
    if port:
        folder = "/dev/" if port[2] and not port[1] else ""
        return Message(
            "unknown backend '{name}'; to use a port, name its backend: serial:{folder}{spec}",
            name=name,
            folder=folder,
            spec=spec,
        )
    return Message(
        "unknown backend '{name}'; {expected_one_of}",
        name=name,
        expected_one_of=expected_one_of(name, backend_names()),
    )


def open_plate(spec: str, *, clock: Clock, seed: int = 0) -> PlateDriver:
    """Return the driver for a SPEC such as ``mock``, ``serial:PORT`` or ``scpi:RESOURCE``.

    If nothing switches the plate off when this process is killed, the SPEC must acknowledge an
    interlock: ``interlock=TEXT``.

    Raises
    ------
    UserError
        If no backend with this name is installed, or if an interlock is required.
    """
    name, _, address = spec.partition(":")
    interlock = ""
    if not spec.startswith(PAIR):
        words = address.split(",")
        interlock = next((each for each in words if each.startswith(INTERLOCK)), "")
        address = ",".join(each for each in words if not each.startswith(INTERLOCK))
    found = {point.name: point for point in _installed()}
    if name not in found:
        raise UserError(
            "plate '{spec}': {unknown_backend}", spec=spec, unknown_backend=unknown_backend(spec)
        )
    backend: Backend = found[name].load()
    LOG.info("chose backend %s: %s", name, found[name].value)
    driver = backend(address, clock=clock, seed=seed)
    if isinstance(driver.unattended, Unguarded):
        driver.interlock = interlock.removeprefix(INTERLOCK)
        if not driver.interlock:
            raise UserError(
                "plate '{spec}': if this program is killed, nothing switches the plate off "
                "({why}); install an interlock, and name it in the SPEC, such as "
                "{interlock}foot_switch",
                spec=spec,
                why=driver.unattended.why,
                interlock=INTERLOCK,
            )
    return driver
