"""Print the comparison with the paper on the terminal."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from slipscale.analysis.reproduction.comparison import Comparison, Group

AGREES: dict[Group, str] = {
    "agrees": "[green]yes[/]",
    "differs": "[yellow]no[/]",
    "by construction": "by construction",
    "not published": "–",
}


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
            AGREES[outcome.group] + (" [red]drifted[/]" if comparison.drifted else ""),
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


def _summary(comparisons: Sequence[Comparison]) -> str:
    groups = Counter(comparison.outcome.group for comparison in comparisons)
    return (
        f"Independent items: {groups['agrees']} agree with the paper, and {groups['differs']} "
        f"differ, for the reasons given above. By construction, {groups['by construction']} "
        "items agree (definitions, and values set to the published ones or computed from other "
        "numbers in the paper). For "
        f"{groups['not published']} items, the paper gives no number. The exit status is 0 if all "
        "computed values match the recorded values and all cells of Table III agree, even if other "
        "items do not agree with the paper."
    )
