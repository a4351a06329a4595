"""Test the conformance kit with deliberately faulty boards.

Usage: ``python -m tools.campaigns wrong_boards`` (some minutes). Prints, for each kind of faulty
board, which protocol rules and which guided tests detect it. The exit status is 1 if neither
detects a kind, or if the correct board violates a rule.

Each kind is a variant of the emulated board, in virtual time.
"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from slipscale.hardware.emulator.firmware import Board
from tools.campaigns.wrong_boards.variants import WRONG, NoOnTimeLimit
from tools.campaigns.wrong_boards.verdicts import departures, guided_departures


def add_arguments(_: ArgumentParser) -> None:
    """Add no arguments."""


def run(_: Namespace) -> tuple[int, str]:
    """Run the campaign."""
    unfound = 0
    kinds: tuple[type[Board], ...] = (Board, *WRONG)
    for kind in kinds:
        by_wire = departures(kind, long=kind in {Board, NoOnTimeLimit})
        by_guide = guided_departures(kind)
        found = bool(by_wire or by_guide)
        wrong = found == (kind is Board)
        unfound += wrong
        what = (kind.__doc__ or "").splitlines()[0] if kind is not Board else "The correct board."
        print(f"{'WRONG ' if wrong else ''}{kind.__name__}: {what}")
        for part, rules in (("wire", by_wire), ("guided", by_guide)):
            for rule, detail in list(rules.items())[:3]:
                print(f"    {part:<7} {rule}: {detail[:110]}")
    print(f"{len(WRONG)} kinds of faulty board, {unfound} wrong verdicts")
    return int(unfound > 0), ""
