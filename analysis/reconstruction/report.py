"""What `slipscale reconstruct` says: records for machines, a table for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from analysis.reconstruction.marginals import Marginals, marginals
from analysis.reconstruction.published_table import CONVENTIONS, PublishedTable, Scale
from analysis.reconstruction.rounding import RULES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from analysis.reconstruction.solutions import Solutions

# What is worth its time on the command line: so many cells of the tables of states, each once
# for every goal, and so many additions for the ordered samples when multisets are asked for.
MARGINAL_CELLS = 5_000_000
ORDERED_ADDITIONS = 6_000_000_000


def column_record(solutions: Solutions, measure: str) -> dict[str, Any]:
    """Return one column's answer, counts as strings."""
    column = solutions.column
    record: dict[str, Any] = {
        "label": column.label,
        "consistent": solutions.consistent,
        "reason": solutions.reason,
        "multisets": str(solutions.multisets),
        "ordered": str(solutions.ordered) if worth_ordering(solutions, measure) else None,
        "sd_convention": column.sd_convention,
        "rounding": column.rounding,
        "grim": solutions.targets.grim,
        "grimmer": solutions.targets.grimmer,
        "sums": [
            {"sum": str(total), "sum_of_squares": str(squares)}
            for total, squares in moments(solutions)
        ],
    }
    cells = sum((task.bytes // 8) * len(task.goals) for task in solutions.problems)
    if solutions.consistent and cells <= MARGINAL_CELLS:
        found = marginals(solutions, measure)
        record["order_statistics"] = order_statistics(found, column.scale)
    return record


def worth_ordering(solutions: Solutions, measure: str) -> bool:
    """Whether ordered samples are counted: asked for, or few enough additions."""
    n, values = solutions.column.n, solutions.column.scale.steps + 1
    cells = sum(task.bytes // 8 for task in solutions.problems)
    return measure == "ordered" or cells * n * values <= ORDERED_ADDITIONS


def moments(solutions: Solutions) -> list[tuple[Any, Any]]:
    """Return the admissible sums and sums of squares in the scale's own unit."""
    low, step = solutions.column.scale.minimum, solutions.column.scale.step
    return [
        (
            m.n * low + step * m.total,
            m.n * low**2 + 2 * low * step * m.total + step**2 * m.squares,
        )
        for m in solutions.targets.moments
    ]


def order_statistics(found: Marginals, scale: Scale) -> list[dict[str, Any]]:
    """Return for each order statistic its sharp bounds and its mean over all data sets."""
    rows = []
    for i in range(1, found.n + 1):
        chances = found.order_statistic(i)
        mean = sum(p * scale.value(v) for v, p in chances.items())
        rows.append(
            {
                "rank": i,
                "minimum": float(scale.value(min(chances))),
                "maximum": float(scale.value(max(chances))),
                "mean": float(mean),
            }
        )
    return rows


def variants(solutions: Solutions) -> list[dict[str, Any]]:
    """Return the answer under every SD convention and rounding rule."""
    rows = []
    known: dict[Any, tuple[int, str]] = {}
    for convention in CONVENTIONS:
        for rule in RULES:
            other = solutions.under(convention, rule)
            # Rules that admit the same sums admit the same data sets.
            if other.targets.wanted not in known or not other.targets.wanted:
                known[other.targets.wanted] = (other.multisets, other.reason)
            count, reason = known[other.targets.wanted]
            rows.append(
                {
                    "sd_convention": convention,
                    "rounding": rule,
                    "consistent": count > 0,
                    "reason": reason,
                    "multisets": str(count),
                }
            )
    return rows


def lines(table: PublishedTable, records: Iterable[dict[str, Any]]) -> list[str]:
    """Return the answer for people, a line each."""
    said = [table.title or "published table", ""]
    for record in records:
        said.append(
            f"{record['label']}  ({record['sd_convention']} SD, rounding: {record['rounding']})"
        )
        if record["consistent"]:
            said.append(f"  multisets        {int(record['multisets']):,}")
            ordered = record["ordered"]
            said.append(
                f"  ordered samples  {int(ordered):,}"
                if ordered
                else "  ordered samples  not counted, it takes long; --measure ordered does"
            )
            pairs = "; ".join(f"{p['sum']}, {p['sum_of_squares']}" for p in record["sums"])
            said.append(f"  sum, sum of squares  {pairs}")
        else:
            said.append(f"  inconsistent: {record['reason']}")
        if "order_statistics" in record:
            ranges = "  ".join(
                f"{row['minimum']:g}-{row['maximum']:g}" for row in record["order_statistics"]
            )
            said.append(f"  sorted ratings, range over all data sets: {ranges}")
        for variant in record.get("variants", ()):
            verdict = f"{int(variant['multisets']):,} multisets"
            said.append(
                f"    {variant['sd_convention']:<10} {variant['rounding']:<10} "
                f"{verdict if variant['consistent'] else variant['reason']}"
            )
        said.append("")
    return said
