"""Power on the terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.planning.power import Power
    from experiments.study.analysis_choices import Primary


#: Primary analysis -> the tests whose power is shown.
TESTS: dict[Primary, str] = {
    "ranks": "Friedman; Wilcoxon between neighbours",
    "logarithms": "ANOVA of logarithms (Greenhouse-Geisser); paired t between neighbours",
}


def print_power(
    curve: Sequence[Power],
    target: float,
    enough: int | None,
    repetitions: int,
    *,
    primary: Primary = "ranks",
    console: Console | None = None,
) -> None:
    """Print power against the number of participants, and how many suffice."""
    table = Table(
        title=f"Power of simulated studies ({curve[0].studies} each, {repetitions} "
        f"estimate{'s' if repetitions > 1 else ''} of a surface)",
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
    )
    table.add_column("participants", justify="right")
    table.add_column("any\ndifference", justify="right")
    for low, high in curve[0].steps:
        table.add_column(f"{low:g} - {high:g}\nµm p-p", justify="right")
    table.add_column("exponent\n± 95 %", justify="right")
    for point in curve:
        shares = [point.omnibus, *point.steps.values()]
        cells = [f"[bold]{s:.3f}[/]" if s >= target else f"{s:.3f}" for s in shares]
        table.add_row(str(point.participants), *cells, f"{point.exponent_half_width:.2f}")
    target_console = console or Console()
    target_console.print(table)
    target_console.print(
        f"{enough} participants or more reach {target:g} on every test."
        if enough
        else f"None of these sizes reaches {target:g} on every test.",
        highlight=False,
    )
    target_console.print(
        f"[dim]{TESTS[primary]}, Holm-corrected over all pairs. The "
        "population has Table III's means and spreads; how ratings pair up is an assumption.[/]"
    )
