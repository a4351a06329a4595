"""Declare thresholds from forced choice."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.declared.one_statistic import of_one_statistic
from slipscale.analysis.tasks.thresholds import figures, section, sentences, table
from slipscale.analysis.tasks.thresholds.reading import TRIALS
from slipscale.analysis.tasks.thresholds.session_tables import session_tables
from slipscale.analysis.tasks.thresholds.statistics import THRESHOLDS

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    from matplotlib.figure import Figure

    from slipscale.analysis.tasks.thresholds.statistics import TaskThresholds
    from slipscale.stimuli.quantity import Quantity


def _figures(
    task: TaskThresholds, trials: pd.DataFrame, quantity: Quantity
) -> Mapping[str, Figure]:
    own = trials[trials["task"] == task.task]
    drawn = {f"thresholds_{task.task}": figures.functions(task, own, quantity)}
    if own["track"].notna().any():
        drawn[f"tracks_{task.task}"] = figures.tracks(task, own, quantity)
    return drawn


ANALYSIS = of_one_statistic(
    "thresholds",
    TRIALS,
    THRESHOLDS,
    question="How small {q.a_level}, or a change in it, can be felt?",
    what="forced choice",
    title="Thresholds",
    answers=lambda task, level, q: [sentences.answer(task, level, q)],
    sentences=sentences.sentences,
    doubts=sentences.doubts,
    blocks=section.blocks,
    figures=_figures,
    rows=table.rows,
    session_tables=session_tables,
)
