"""Declare what happens to a backend's output when the session is killed or frozen.

Every backend declares one of these in `PlateDriver.unattended`:

================  ==============================================================================
`Guarded`         a guard process (`slipscale.hardware.output.guard`) switches the output off
`StopsAlone`      the device or the operating system switches the output off
`Unguarded`       nothing does: an interlock is required (`slipscale.hardware.registry`)
================  ==============================================================================
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol


class Switch(Protocol):
    """What a guard process holds: an instrument, or the means to reach it.

    The session can call further methods by name. Their arguments and results are texts.
    """

    def switch_off(self) -> None:
        """Switch the output off, and check that it is off; repeated until no `PlateFault`."""


@dataclass(frozen=True, slots=True)
class Guarded:
    """The guard process calls `opens`, a function that can be pickled, to get its `Switch`."""

    opens: Callable[[], Switch]


@dataclass(frozen=True, slots=True)
class StopsAlone:
    """The output ends without a guard, for the reason ``why``."""

    why: str


@dataclass(frozen=True, slots=True)
class Unguarded:
    """The output stays on, for the reason ``why``."""

    why: str


Unattended = Guarded | StopsAlone | Unguarded
