"""Run random histories of a plate, and check the guarantees of `slipscale.hardware.driver`."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING
from unittest import mock

from slipscale.faults import UserError
from slipscale.hardware.errors import OverLimit, PlateFault
from slipscale.hardware.records import Output
from slipscale.stimuli.surface import VirtualSurface
from tools.campaigns.output_states.rigs import EVENTS, RESONANCE_HZ, RIGS, Rig

if TYPE_CHECKING:
    from slipscale.hardware.driver import PlateDriver


TOLERANCE, TOLERANCE_UM = 0.05, 0.06
RESTS_UM = 0.001
# Weights: present an amplitude, switch off, exceed the limits, change the rig, other commands.
SHARES = {"present": 35, "0": 10, "9": 5, "happens": 25, "other": 25}
AMPLITUDES_UM_PP = (0.3, 0.5, 1.0, 1.2, 2.0, 2.3)


@dataclass
class History:
    """Commands and events of a rig, and the guarantees that were violated."""

    rig: Rig
    events: list[str] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    presented: int = 0
    faults: int = 0

    def command(self, name: str, act: Callable[[], object], *, wanted_um_pp: float | None) -> None:
        """Run a command, and check the guarantees."""
        self.events.append(name)
        raised: Exception | None = None
        before = self.rig.plate.output
        try:
            act()
        except (PlateFault, UserError) as fault:
            raised = fault
            self.faults += 1
        true_um_pp, output = self.rig.true_um_pp(), self.rig.plate.output
        refused = isinstance(raised, OverLimit | UserError) and output is before
        if raised is None and wanted_um_pp is not None:
            self.presented += 1
            if abs(true_um_pp - wanted_um_pp) > max(TOLERANCE * wanted_um_pp, TOLERANCE_UM):
                self._break(f"presented {wanted_um_pp:g} µm p-p, true amplitude {true_um_pp:.3f}")
        if output is Output.OFF and true_um_pp > RESTS_UM and wanted_um_pp != 0:
            self._break(f"confirmed off, but driven at {true_um_pp:.3f} µm p-p")
        if raised is not None and output is Output.MAY_BE_ON and not refused:
            self._break(f"the plate may be on after {type(raised).__name__}")

    def end(self) -> None:
        """Close the plate."""
        self.events.append("close")
        with suppress(PlateFault):
            self.rig.plate.close()
        if self.rig.plate.output is not Output.UNREACHABLE and self.rig.true_um_pp() > RESTS_UM:
            self._break(f"left on, and {self.rig.plate.output}")
        if self.rig.plate.output is Output.MAY_BE_ON:
            self._break("the plate may be on after it was closed")

    def _break(self, how: str) -> None:
        self.broken.append(f"{how} (after {', '.join(self.events)})")


def lived(backend: str, seed: int, events: int = EVENTS) -> History:
    """Run random commands and events on a backend, and return their history."""
    draw = random.Random(f"{backend} {seed}")
    rig = RIGS[backend]()
    history = History(rig)
    plate, names = rig.plate, list(rig.happenings)
    with mock.patch.dict(sys.modules, rig.modules):
        history.command("connect", plate.connect, wanted_um_pp=None)
        for _ in range(events):
            kind = draw.choices(list(SHARES), list(SHARES.values()))[0]
            if kind == "happens":
                name = draw.choice(names)
                history.events.append(name)
                rig.happenings[name]()
            elif kind == "other":
                name = draw.choice(["silence", "check", "read_back", "excite", "reconnect"])
                history.command(name, partial(_other, plate, name), wanted_um_pp=None)
            else:
                wanted = draw.choice(AMPLITUDES_UM_PP) if kind == "present" else float(kind)
                surface = VirtualSurface(level=wanted)
                act = partial(plate.present, surface)
                history.command(f"present {wanted:g}", act, wanted_um_pp=wanted)
        history.end()
    return history


def _other(plate: PlateDriver, name: str) -> None:
    if name == "excite":
        plate.excite(frequency_hz=RESONANCE_HZ, voltage_v=3.0)
    elif name == "reconnect":
        plate.close()
        plate.connect()
    else:
        getattr(plate, name)()
