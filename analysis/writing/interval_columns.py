"""An interval as the columns of a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from slipscale.analysis.json_form import JsonObject
    from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval


def bounds(interval: ConfidenceInterval | None) -> JsonObject:
    """Return an interval's two columns."""
    low, high = (None, None) if interval is None else interval
    return {"ci_low": low, "ci_high": high}
