"""Data set columns for adjustments: the final amplitude and every intermediate amplitude."""

from __future__ import annotations

from typing import Any

from slipscale.experiments.steps.columns import Column, Given, TrialRecord


def _field(record: TrialRecord, name: str, field: str) -> Any:
    return record.answers.get(name, {}).get(field)


def _trace(record: TrialRecord, name: str) -> str | None:
    found = _field(record, name, "trace")
    return " ".join(f"{at_s:.3f}:{level:g}" for at_s, level in found) if found else None


def _turns(record: TrialRecord, name: str) -> float | None:
    found = _field(record, name, "trace")
    return float(len(found) - 1) if found else None


def adjusted_columns(name: str, description: str) -> dict[str, Column]:
    """Return the columns for an adjustment: the final amplitude and every intermediate amplitude.

    Parameters
    ----------
    name : str
        The adjustment's name; it ends in ``_level``.
    description : str
        Description of the final amplitude.
    """
    return {
        name: Column(
            value=Given(_field, (name, "value")),
            description=f"{description}, commanded{{q.behind}}",
            units="{q.bids}",
        ),
        f"{name.removesuffix('_level')}_readback_level": Column(
            value=Given(_field, (name, "readback_level")),
            description=f"{description}, as read back from the plate{{q.behind}}",
            units="{q.bids}",
        ),
        "turns": Column(
            value=Given(_turns, (name,)),
            description="Number of changes of the {q.name} during the adjustment",
        ),
        "trace": Column(
            value=Given(_trace, (name,)),
            kind="text",
            description="{q.in_full_title} at the start and after each change, each written as "
            "seconds from the beginning, a colon and {q.unit_in_full}",
        ),
    }
