"""List all rules for a driver board, and check a board against them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from slipscale.hardware.conformance import command_rules, line_rules, plate_rules, truth_rules
from slipscale.hardware.conformance.bench import Bench, Departure, NotApplicable, NotProved

RULES = (*line_rules.RULES, *command_rules.RULES, *plate_rules.RULES, *truth_rules.RULES)

Outcome = Literal["conforms", "departs", "not applicable", "not proved"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Result for one rule; ``detail`` explains every other outcome than "conforms".

    A rule that was "not proved" needs a loaded plate, a long run or a person.
    """

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
        yield judged(bench, rule, check)


def judged(bench: Bench, rule: str, check: Callable[[Bench], object]) -> Verdict:
    """Check one rule, and switch the plate off."""
    try:
        check(bench)
    except Departure as departure:
        found = Verdict(rule=rule, outcome="departs", detail=str(departure))
    except NotApplicable as reason:
        found = Verdict(rule=rule, outcome="not applicable", detail=str(reason))
    except NotProved as reason:
        found = Verdict(rule=rule, outcome="not proved", detail=str(reason))
    else:
        found = Verdict(rule=rule, outcome="conforms")
    bench.silence()
    return found
