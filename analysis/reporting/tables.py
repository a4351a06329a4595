"""Results as tables: what the CSV files hold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from slipscale.analysis.reporting.json_form import record
from slipscale.analysis.reporting.task_tables import task_tables
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.dataset.schema import PARTICIPANT

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipscale.analysis.reporting.json_form import JsonObject
    from slipscale.analysis.result import Analysis
    from slipscale.analysis.statistics.descending_difference.yes_no import StepAnswers
    from slipscale.analysis.statistics.measured_friction import ParticipantLine
    from slipscale.analysis.statistics.pairwise import PairComparison


def tables(analysis: Analysis) -> dict[str, pd.DataFrame]:
    """Return the tables to write as CSV, by name."""
    found: dict[str, pd.DataFrame] = {"quality": quality_table(analysis)}
    if len(analysis.individuals):
        found["individuals"] = analysis.individuals
    if analysis.prepared is not None:
        columns = ["participant_id", "session", "run", "trial", "amplitude_um_pp", "estimate"]
        columns += ["normalised", "response_time"]
        trials = analysis.estimates
        if (trials["trial"].dropna() % 1 == 0).all():
            trials = trials.astype({"trial": "Int64"})
        kept = [name for name in columns if not trials[name].isna().all()]
        found |= {
            "table3": analysis.table3,
            "descriptives": analysis.description,
            "estimates": trials[kept],
            "wide": wide(analysis),
        }
        if len(analysis.textures):
            found["textures"] = analysis.textures
        if analysis.friction is not None and analysis.friction.participants:
            found["friction"] = flat(analysis.friction.participants)
        pairs = analysis.inference.pairwise
        if not isinstance(pairs, NotComputed):
            found["pairwise"] = flat(pairs)
    difference = analysis.inference.difference
    if not isinstance(difference, NotComputed):
        found["answers"] = answers(analysis)
        if difference.steps:
            found["difference"] = flat(difference.steps)
    own = {
        f"own_{each.name}": each.found.table
        for each in analysis.own
        if not isinstance(each.found, NotComputed) and each.found.table is not None
    }
    return found | task_tables(analysis) | own


#: Columns of a yes or no, where they hold anything.
ANSWERS = (
    *(PARTICIPANT, "session", "run", "series", "trial", "step"),
    *("amplitude_before_um_pp", "amplitude_um_pp", "catch", "difference_felt"),
    *("confidence", "response_time", "verbal_report"),
)


def answers(analysis: Analysis) -> pd.DataFrame:
    """Return the analysed answers of yes and no: all that the difference task's numbers rest on.

    Of another quantity than the plate's, the stimulus and its reference.
    """
    rows = analysis.dataset.differences
    kept = [name for name in ANSWERS if name in rows and not _empty(rows[name])]
    table = rows[kept].astype({"difference_felt": int})
    if not analysis.dataset.quantity.of_plate:
        return table.rename(
            columns={
                "amplitude_before_um_pp": "amplitude_um_pp",
                "amplitude_um_pp": "reference",
                "difference_felt": "yes",
            }
        )
    return table


def _empty(cells: pd.Series[Any]) -> bool:
    return bool(cells.isna().all() or (cells.astype(str) == "").all())


def flat(rows: Sequence[PairComparison | StepAnswers | ParticipantLine]) -> pd.DataFrame:
    """Return results as a table, under inference.json's keys.

    An interval ``[low, high]`` becomes two columns, such as ``ratio_ci_low ratio_ci_high``.
    """
    cells: list[JsonObject] = []
    for row in rows:
        cells.append({})
        for name, value in record(row).items():
            parts = zip(("_low", "_high"), value, strict=True) if isinstance(value, list) else ()
            cells[-1] |= {name + end: bound for end, bound in parts} or {name: value}
    return pd.DataFrame(cells)


def wide(analysis: Analysis) -> pd.DataFrame:
    """Return one row a participant, as JASP, jamovi and SPSS read repeated measures.

    Names are letters, digits and underscores: ``estimate_0_5`` is the mean normalised estimate
    at 0.5 µm peak to peak, ``log_0_5`` the mean natural logarithm.
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
        # Our columns keep their names; a column of participants.tsv of the same name is marked.
        table = table.merge(
            about, on="participant_id", how="left", suffixes=("", "_participants_tsv")
        )
    return table


def quality_table(analysis: Analysis) -> pd.DataFrame:
    """Return every participant's measures, flags and exclusion."""
    names = list(analysis.flags.columns)
    raised = [
        ";".join(name for name, on in zip(names, row, strict=True) if on)
        for row in analysis.flags.to_numpy(bool).tolist()
    ]
    table = analysis.measures.assign(
        flags=raised, excluded=analysis.measures.index.isin(list(analysis.excluded))
    )
    return table.reset_index()
