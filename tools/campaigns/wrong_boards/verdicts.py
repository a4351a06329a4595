"""Find the protocol rules that a faulty board violates, and the guided tests that it fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.hardware.conformance.bench import Bench
from slipscale.hardware.conformance.guided import guide
from slipscale.hardware.conformance.table import examine
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad
from slipscale.hardware.plate.twin import Twin
from tools.campaigns.wrong_boards.virtual_line import Operator, VirtualLine

if TYPE_CHECKING:
    from slipscale.hardware.emulator.firmware import Board


def departures(kind: type[Board], *, long: bool = False) -> dict[str, str]:
    """Return the protocol rules that a kind of board violates, with details.

    If a board violates no rule on a free plate, a plate with a finger is tried.
    """
    for finger in (NO_FINGER, FingerLoad(loss=1 / 300)):
        line = VirtualLine(kind(Twin(finger=finger), boot=1))
        verdicts = examine(Bench(line, line, long=long))
        if found := {each.rule: each.detail for each in verdicts if each.outcome == "departs"}:
            return found
    return {}


def guided_departures(kind: type[Board]) -> dict[str, str]:
    """Return the guided tests that a kind of board fails, with details."""
    line = VirtualLine(kind(Twin(), boot=1))
    bench = Bench(line, line)
    verdicts = guide(bench, Operator(line, bench))
    return {each.rule: each.detail for each in verdicts if each.outcome == "departs"}
