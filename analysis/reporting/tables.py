"""Build the result tables for the CSV files."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from slipscale.analysis.tasks.kind import Analysis


def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Return the result tables, keyed by name."""
    found: dict[str, pd.DataFrame] = {"quality": quality_table(analysis)}
    if len(analysis.individuals):
        found["individuals"] = analysis.dataset.quantity.columns(analysis.individuals)
    for kind in analysis.kinds:
        found |= kind.tables(analysis)
    return found


def quality_table(analysis: Analysis) -> pd.DataFrame:
    """Return a table of each participant's quality measures, flags and exclusion."""
    names = list(analysis.flags.columns)
    raised = [
        ";".join(name for name, on in zip(names, row, strict=True) if on)
        for row in analysis.flags.to_numpy(bool).tolist()
    ]
    table = analysis.measures.assign(
        flags=raised, excluded=analysis.measures.index.isin(list(analysis.excluded))
    )
    return table.reset_index()
