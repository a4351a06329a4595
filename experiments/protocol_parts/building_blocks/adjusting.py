"""Data set columns for adjustments: the final amplitude and every intermediate amplitude."""

from __future__ import annotations

from typing import Any

from slipscale.experiments.steps.columns import Column, TrialRecord


def adjusted_columns(name: str, description: str) -> dict[str, Column]:
    """Return the columns for an adjustment: the final amplitude and every intermediate amplitude.

    Parameters
    ----------
    name : str
        The adjustment's name; it ends in ``_level``.
    description : str
        Description of the final amplitude.
    """

    def of(field: str, record: TrialRecord) -> Any:
        return record.answers.get(name, {}).get(field)

    def trace(record: TrialRecord) -> str | None:
        found = of("trace", record)
        return " ".join(f"{at_s:.3f}:{level:g}" for at_s, level in found) if found else None

    def turns(record: TrialRecord) -> float | None:
        found = of("trace", record)
        return float(len(found) - 1) if found else None

    return {
        name: Column(
            value=lambda record: record.answer(name),
            description=f"{description}, commanded{{q.behind}}",
            units="{q.bids}",
        ),
        f"{name.removesuffix('_level')}_readback_level": Column(
            value=lambda record: of("readback_level", record),
            description=f"{description}, as read back from the plate{{q.behind}}",
            units="{q.bids}",
        ),
        "turns": Column(
            value=turns, description="Number of changes of the {q.name} during the adjustment"
        ),
        "trace": Column(
            value=trace,
            kind="text",
            description="{q.in_full_title} at the start and after each change, each written as "
            "seconds from the beginning, a colon and {q.unit_in_full}",
        ),
    }
