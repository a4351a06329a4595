"""Declare the statistic that relates judgements to measured friction."""

from __future__ import annotations

from slipscale.analysis.statistics.measured_friction import MeasuredFriction, measured_friction
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Inputs, Statistic


class _MeasuredFriction(Statistic[MeasuredFriction]):
    key = "measured_coefficient"
    meaning = "mean slope of log estimates on the friction measured in the same trials"
    test = False
    families = (
        Family(
            name="slope on measured friction, t test",
            read=lambda found: [found.slope.p] if found.slope else [],
        ),
    )
    methods = (
        "Each participant's log estimates were regressed on the coefficient of friction measured "
        "in the same trials; the mean slope was compared with 0 by a t test, and correlations were "
        "averaged with Fisher's z."
    )

    def compute(self, inputs: Inputs) -> MeasuredFriction | NotComputed:
        found = measured_friction(inputs.prepared)
        return (
            NotComputed("no coefficient was measured in the same trials")
            if found is None
            else found
        )


MEASURED_FRICTION = _MeasuredFriction()
