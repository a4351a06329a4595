"""List all rules for a driver board, and check a board against them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from slipscale.hardware.conformance import command_rules, line_rules, plate_rules, truth_rules
from slipscale.hardware.conformance.bench import Bench, Departure, NotApplicable

RULES = (*line_rules.RULES, *command_rules.RULES, *plate_rules.RULES, *truth_rules.RULES)

Outcome = Literal["conforms", "departs", "not applicable"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Result for one rule; ``detail`` explains a violation or why the rule does not apply."""

    rule: str
    outcome: Outcome
    detail: str = ""


def examine(bench: Bench) -> Iterator[Verdict]:
    """Check a board against all rules, one by one. The plate is off before and after each check.

    Raises
    ------
    PlateFault
        If communication fails.
    """
    try:
        bench.greet()
    except Departure as departure:
        yield Verdict(rule="the board answers and reports its limits", outcome="departs",
                      detail=str(departure))  # fmt: skip
        return
    for rule, check in RULES:
        try:
            check(bench)
        except Departure as departure:
            yield Verdict(rule=rule, outcome="departs", detail=str(departure))
        except NotApplicable as reason:
            yield Verdict(rule=rule, outcome="not applicable", detail=str(reason))
        else:
            yield Verdict(rule=rule, outcome="conforms")
        bench.silence()
