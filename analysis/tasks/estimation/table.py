"""Build the CSV tables for magnitude estimation."""

from __future__ import annotations

import pandas as pd

from slipscale.analysis.reading.trial_tables import factor_columns
from slipscale.analysis.tasks.declared.flat_table import flat
from slipscale.analysis.tasks.estimation.statistics import PAIRWISE
from slipscale.analysis.tasks.kind import Analysis


def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Return the tables for magnitude estimation, keyed by name."""
    if analysis.prepared is None:
        return {}
    named = analysis.dataset.quantity.columns
    columns = ["participant_id", "session", "run", "trial", "level", "estimate"]
    trials = analysis.estimates.assign(normalisation=analysis.rule)
    columns += ["scale_top", "modulus", "normalised", "normalisation", "response_time"]
    columns += ["position", "before_level", *factor_columns(trials)]
    if (trials["trial"].dropna() % 1 == 0).all():
        trials = trials.astype({"trial": "Int64"})
    kept = [name for name in columns if not trials[name].isna().all()]
    found = {
        "table3": named(analysis.table3),
        "descriptives": named(analysis.description),
        "estimates": named(trials[kept]),
        "wide": wide(analysis),
    }
    if len(analysis.textures):
        found["textures"] = analysis.textures
    if (pairs := analysis.inference.found(PAIRWISE)) is not None:
        found["pairwise"] = named(flat(pairs))
    return found


def wide(analysis: Analysis) -> pd.DataFrame:
    """Return a wide table (one row per participant), as required by JASP, jamovi and SPSS.

    Column names contain only letters, digits and underscores. For example, ``estimate_0_5`` is the
    mean normalised estimate at 0.5 µm peak to peak, and ``log_0_5`` is the mean natural logarithm.
    """

    def named(table: pd.DataFrame, prefix: str) -> pd.DataFrame:
        return table.rename(columns=lambda a: f"{prefix}_{f'{a:g}'.replace('.', '_')}")

    parts = [named(analysis.cells, "estimate")]
    if analysis.prepared is not None:
        logs = analysis.prepared.logs.reindex(columns=analysis.cells.columns)
        parts.append(named(logs, "log"))
    table = pd.concat(parts, axis=1).rename_axis(columns=None)
    table.index = table.index.astype(str)
    table = table.rename_axis("participant_id").reset_index()
    about = analysis.dataset.participants
    if len(about.columns) > 1:
        about = about.drop_duplicates("participant_id")
        # If a column of participants.tsv has the name of a result, the column gets a suffix.
        table = table.merge(
            about, on="participant_id", how="left", suffixes=("", "_participants_tsv")
        )
    return table
