"""Print power estimates on the terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.table import Table

from slipscale.analysis.planning.power.answers import (
    PRIMARY_TESTS,
    Row,
    assumption,
    fewest,
    sentence,
    varying,
)
from slipscale.analysis.planning.power.yes_no_steps import CATCH_WIDTH, D_PRIME_LOW

if TYPE_CHECKING:
    from slipscale.analysis.planning.power.design import Design

#: Short headings for narrow columns.
SHORT = {"participants": "N", "repetitions": "ratings", "catch_steps": "catch\nsteps"}
WIDTH, WIDEST = 110, 1000
#: Maximum number of condition columns for which all pairs are shown.
NARROW = 2


def print_power(design: Design, found: Sequence[Row], target: float) -> None:
    """Print the power in each condition, and the smallest sufficient number of participants."""
    # On a narrow terminal, lines wrap instead of truncating numbers.
    target_console = Console()
    target_console.width = max(target_console.width, WIDTH)
    table = Table(
        title=f"Power: proportion of significant results in {found[0].weakest.studies:,} "
        "simulated studies",
        title_justify="left",
        title_style="bold",
        box=box.SIMPLE_HEAD,
    )
    axes = varying(found)
    columns = _columns(design, found[0], target, brief=len(axes) > NARROW)
    for title in (*(SHORT.get(axis, axis) for axis in axes), *columns):
        table.add_column(title, justify="right", no_wrap=True)
    for row in found:
        values = [row.condition.told(axis) for axis in axes]
        table.add_row(*values, *(cell(row) for cell in columns.values()))
    needed = target_console.measure(table, options=target_console.options.update(width=WIDEST))
    target_console.width = max(target_console.width, needed.maximum)
    target_console.print(table)
    errors = [share.error for row in found for share in row.power.values()]
    lines = [f"Monte Carlo standard errors are at most {max(errors):.3f}."]
    for line in (*lines, *summary(design, found, target)):
        target_console.print(line, highlight=False, markup=False)


def _columns(
    design: Design, first: Row, target: float, *, brief: bool
) -> dict[str, Callable[[Row], str]]:
    """Return functions that format a condition's value for each column, keyed by heading."""
    columns: dict[str, Callable[[Row], str]] = {}
    amplitudes = [name for name in first.decisive if name not in design.factor_tests]
    for name in amplitudes[: 1 if brief else None]:
        title = f"{name}\n{design.unit}" if " - " in name else "any"
        columns[title] = partial(_power, name, target)
    for name in (*design.factor_tests, *design.mixed_tests):
        columns[name.replace(" x ", "\nx ").replace(", ", ",\n")] = partial(_power, name, target)
    if brief:
        columns["weakest"] = lambda row: _share(row.weakest.value, target)
    columns["exponent\n±"] = _width
    if first.steps:
        columns["yes at\ncatch ±"] = lambda row: f"{row.steps[CATCH_WIDTH].mean:.3f}"
        columns["d' at\nleast"] = lambda row: f"{row.steps[D_PRIME_LOW].mean:.2f}"
    if first.false_alarms:
        columns["false\nalarms"] = lambda row: f"{row.false_alarms[row.decisive[0]].value:.3f}"
    if first.assurance is not None:
        columns["assur-\nance"] = lambda row: f"{row.assurance:.3f}"
    if first.looks:
        columns["with\nlooks"] = lambda row: f"{row.any_look:.3f}"
        columns["mean\nN"] = lambda row: f"{row.expected_participants:.1f}"
    if first.false_looks:
        columns["looks,\nno effect"] = lambda row: (
            f"{row.false_looks.value:.3f}" if row.false_looks else ""
        )
    return columns


def _of_factors(design: Design) -> list[str]:
    """Describe how factors are tested, if the study has factors."""
    known = [name for name, _ in design.task.factors]
    if not known:
        return []
    tested = (
        f"Factors ({', '.join(known)}): each factor is tested together with the {design.varied} "
        "in a repeated-measures ANOVA of log estimates, averaged over other factors."
    )
    lines = [tested]
    tests = design.factor_tests
    bounded = [f"{name} x {design.varied}" for name in known if tests[name]]
    absent = [name for name, simulated in tests.items() if not simulated]
    if none := [name for name in absent if name not in bounded]:
        lines.append(
            f"No effect is simulated for {', '.join(none)}, so these values are false-alarm "
            "rates. To simulate an effect, set simulated or simulated_growth in [[factors]]."
        )
    if some := [name for name in absent if name in bounded]:
        lines.append(
            f"{', '.join(some)}: no change in growth is simulated, but the top of the scale limits "
            "large answers. An effect therefore changes large answers by a smaller ratio than "
            "small answers, which is an interaction."
        )
    if mixed := design.mixed_tests:
        lines.append(
            f"Mixed model of all trials ({'; '.join(mixed)}): changes from the factor's first "
            "level, as in the report, with uncorrected p-values."
        )
    else:
        lines.append(
            "To add changes estimated by the mixed model (slow), list factors under tests in the "
            "[analysis] table."
        )
    return lines


def _power(name: str, target: float, row: Row) -> str:
    return _share(row.power[name].value, target)


def _share(value: float, target: float) -> str:
    return f"[bold]{value:.3f}[/]" if value >= target else f"{value:.3f}"


def _width(row: Row) -> str:
    width = row.widths["exponent"].mean
    return f"{width:.3f}" if math.isfinite(width) else "none"


def summary(design: Design, found: Sequence[Row], target: float) -> list[str]:
    """Summarise the table in sentences, one per conclusion."""
    lines = []
    others = [axis for axis in varying(found) if axis != "participants"]
    for condition, size in fewest(found, target).items():
        where = condition.described(others)
        answer = (
            f"{size} participants or more reach a power of {target:g} in every comparison"
            if size
            else f"none of these sample sizes reaches a power of {target:g} in every comparison"
        )
        line = f"{where}: {answer}" if where else answer[0].upper() + answer[1:]
        lines.append(f"{line}.")
    if found[0].steps:
        lines.append(
            'Catch steps: half-width of the interval for the proportion of "yes" answers, and '
            "lower bound of d', averaged across studies."
        )
    best = next((row for row in found if row.weakest.value >= target), found[-1])
    lines.append(f"For the application: {sentence(design, best)}")
    refused = max(row.unusable.value for row in found)
    if refused:
        lines.append(
            f"Up to {refused:.1%} of the studies could not be normalised; they count as studies "
            "without significant results."
        )
    lines += [*_of_factors(design), *filter(None, [assumption(design)])]
    lines.append(
        f"Tests: {PRIMARY_TESTS[design.choices.primary]}; normalised by {design.rule}; "
        f"excluded: {', '.join(design.choices.exclusions) or 'nobody'}. For the assumptions "
        "about people, see docs/explanation/simulated-people.md."
    )
    return lines
