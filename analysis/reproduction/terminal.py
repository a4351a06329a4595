"""Print the comparison with the paper on the terminal."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from slipscale.analysis.reproduction.comparison import Comparison, Outcome

AGREES = {True: "[green]yes[/]", False: "[yellow]no[/]", None: "–"}


def print_comparisons(comparisons: Sequence[Comparison]) -> None:
    """Print the published and the computed values, followed by the reasons for differences."""
    # Lines in a file or pipe are not truncated.
    target = Console(width=None if sys.stdout.isatty() else 120)
    table = Table(
        title="Published and computed values",
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
    )
    table.add_column("item", overflow="fold")
    table.add_column("paper", justify="right", no_wrap=True)
    table.add_column("computed", justify="right", overflow="fold")
    table.add_column("unit")
    table.add_column("agrees")
    for comparison in comparisons:
        outcome = comparison.outcome
        table.add_row(
            comparison.item,
            outcome.published or "–",
            outcome.shown,
            outcome.unit,
            ("by construction" if by_construction(outcome) else AGREES[outcome.agrees])
            + (" [red]drifted[/]" if comparison.drifted else ""),
        )
    target.print(table)
    reasons: dict[str, list[str]] = {}
    for comparison in comparisons:
        reasons.setdefault(comparison.outcome.reason, []).append(comparison.item)
    for reason, items in reasons.items():
        named = items[0] if len(items) == 1 else f"{items[0]} ... {items[-1]}"
        target.print(f"[dim]{named}:[/] {reason}", highlight=False)
    target.print(_summary(comparisons), highlight=False)
    for comparison in comparisons:
        if comparison.drifted:
            target.print(
                f"[red]{comparison.item}[/]: the computed value is {comparison.outcome.ours!r}, "
                f"but the recorded value is {comparison.recorded!r}",
                highlight=False,
            )


def by_construction(outcome: Outcome) -> bool:
    """Return whether the computed value agrees with the published value only by construction."""
    return outcome.by_construction and bool(outcome.agrees)


def _summary(comparisons: Sequence[Comparison]) -> str:
    outcomes = [comparison.outcome for comparison in comparisons]
    made = sum(by_construction(outcome) for outcome in outcomes)
    agree = sum(bool(outcome.agrees) for outcome in outcomes) - made
    differ = sum(outcome.agrees is False for outcome in outcomes)
    return (
        f"{agree} items agree with the paper, {made} agree by construction (the computed value was "
        f"derived from the published value or set to it), and {differ} do not agree, for the "
        "reasons given above. The exit status is 0 if all computed values match the recorded "
        "values and all cells of Table III agree, even if other items do not agree with the paper."
    )
