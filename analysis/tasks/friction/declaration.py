"""Declare the comparison of judgements with measured friction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.tasks.declared.flat_table import flat
from slipscale.analysis.tasks.friction import figures, section
from slipscale.analysis.tasks.kind import TaskAnalysis

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    from matplotlib.figure import Figure

    from slipscale.analysis.tasks.kind import Analysis


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    prepared, friction = analysis.prepared, analysis.friction
    if prepared is None or friction is None or not friction.trials:
        return {}
    unit = normalisation.RULES[analysis.rule].unit.format(q=analysis.dataset.quantity)
    return {"rating_friction": figures.rating_friction(prepared, unit=unit)}


def _tables(analysis: Analysis) -> Mapping[str, pd.DataFrame]:
    friction = analysis.friction
    if analysis.prepared is None or friction is None or not friction.participants:
        return {}
    return {"friction": flat(friction.participants)}


ANALYSIS = TaskAnalysis(
    name="friction", sections=(section.measured_friction,), figures=_figures, tables=_tables
)
