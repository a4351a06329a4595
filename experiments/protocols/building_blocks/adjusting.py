"""The columns of an adjustment: where a participant turned the plate to, and on which way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from slipscale.experiments.protocols.base import Column

if TYPE_CHECKING:
    from slipscale.experiments.protocols.base import TrialRecord


def adjusted_columns(name: str, description: str) -> dict[str, Column]:
    """Return the columns of an adjustment: what was reached, and every amplitude on the way.

    Parameters
    ----------
    name : str
        The adjustment's name; it ends in ``_um_pp``.
    description : str
        Of the amplitude reached.
    """

    def of(field: str, record: TrialRecord) -> Any:
        return record.answers.get(name, {}).get(field)

    def trace(record: TrialRecord) -> str | None:
        found = of("trace", record)
        return " ".join(f"{at_s:.3f}:{um_pp:g}" for at_s, um_pp in found) if found else None

    def turns(record: TrialRecord) -> float | None:
        found = of("trace", record)
        return float(len(found) - 1) if found else None

    return {
        name: Column(
            value=lambda record: record.answer(name),
            kind="number",
            description=f"{description}, commanded, peak to peak",
            units="um",
        ),
        f"{name.removesuffix('_um_pp')}_readback_um_pp": Column(
            value=lambda record: of("readback_um_pp", record),
            kind="number",
            description="That amplitude as read back from the plate, peak to peak",
            units="um",
        ),
        "turns": Column(
            value=turns,
            kind="number",
            description="How often the amplitude was changed on the way",
        ),
        "trace": Column(
            value=trace,
            kind="text",
            description="Every amplitude on the way: seconds from the beginning, a colon, µm peak "
            "to peak",
        ),
    }
