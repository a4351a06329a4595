"""Define how the descending difference task is analysed and reported."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from slipscale.analysis.preprocessing.log_transform import Prepared
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import SessionTable
from slipscale.analysis.tasks.declared.flat_table import flat
from slipscale.analysis.tasks.declared.session_tables import by_session
from slipscale.analysis.tasks.difference import figures, section, sentences
from slipscale.analysis.tasks.difference.reading import TRIALS
from slipscale.analysis.tasks.difference.statistics import DIFFERENCE
from slipscale.analysis.tasks.kind import Analysis, TaskAnalysis
from slipscale.analysis.writing.html import ReportSection
from slipscale.analysis.writing.numbers import counted
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.stimuli.quantity import capitalised

#: Columns of the table of yes/no answers; empty columns are omitted.
ANSWERS = (
    *(PARTICIPANT, "session", "run", "series", "trial", "step"),
    *("level_before", "level", "catch", "difference_felt"),
    *("confidence", "response_time", "verbal_report"),
)


def answers_table(analysis: Analysis) -> pd.DataFrame:
    """Return a table of the analysed yes/no answers.

    For quantities other than the plate's amplitude, the table also contains the stimulus and its
    reference.
    """
    rows = analysis.dataset.differences
    kept = [name for name in ANSWERS if name in rows and not _empty(rows[name])]
    table = rows[kept].astype({"difference_felt": int})
    if not analysis.dataset.quantity.stepped:
        return table.rename(
            columns={
                "level_before": "level",
                "level": "reference",
                "difference_felt": "yes",
            }
        )
    return table


def _empty(cells: pd.Series[Any]) -> bool:
    return bool(cells.isna().all() or (cells.astype(str) == "").all())


class _Difference(TaskAnalysis):
    name = "difference"
    trials = TRIALS
    statistics = (DIFFERENCE,)

    def questions(self, analysis: Analysis) -> list[str]:
        if analysis.inference.found(DIFFERENCE) is None:
            return []
        quantity = analysis.dataset.quantity
        return [
            f"Do participants feel a step down in {quantity.name}, and how do they describe it?"
            if quantity.stepped
            else f"How does “{quantity.yes}” depend on {quantity.name}?"
        ]

    def design(self, analysis: Analysis) -> list[str]:
        found = analysis.inference.found(DIFFERENCE)
        if found is None:
            return []
        words = analysis.dataset.quantity.yes_no
        down = counted(sum(step.n for step in found.steps), *words.down)
        return [f"{down} and {counted(found.catch.n, *words.catch)}"]

    def answers(self, analysis: Analysis) -> list[str]:
        found = analysis.inference.found(DIFFERENCE)
        if found is None:
            return []
        data = analysis.dataset
        return sentences.answer(found, data.choices.confidence, data.quantity)

    def doubts(self, analysis: Analysis) -> list[str]:
        found = analysis.inference.found(DIFFERENCE)
        if found is None or not isinstance(found.signal_detection, NotComputed):
            return []
        return [f"Sensitivity was not computed: {found.signal_detection.reason}."]

    def sentences(self, analysis: Analysis) -> Mapping[str, list[str]]:
        data = analysis.dataset
        return {
            capitalised(data.quantity.yes_no.name): sentences.difference_sentences(
                analysis.inference[DIFFERENCE], data.choices.confidence, data.quantity
            )
        }

    def sections(self, analysis: Analysis, svgs: Mapping[str, str]) -> Iterable[ReportSection]:
        return [section.difference(analysis, svgs)]

    def figures(self, analysis: Analysis) -> Mapping[str, Figure]:
        found, data = analysis.inference.found(DIFFERENCE), analysis.dataset
        if found is None or not found.steps:
            return {}
        return {
            "difference": figures.difference(
                found, data.differences, confidence=data.choices.confidence, quantity=data.quantity
            )
        }

    def tables(self, analysis: Analysis) -> Mapping[str, pd.DataFrame]:
        found = analysis.inference.found(DIFFERENCE)
        if found is None:
            return {}
        named = analysis.dataset.quantity.columns
        steps = {"difference": named(flat(found.steps))} if found.steps else {}
        return {"answers": named(answers_table(analysis)), **steps}

    def session_tables(self, data: Dataset, _prepared: Prepared | None) -> Iterator[SessionTable]:
        steps = data.differences
        if len(steps):
            changed = steps[~steps["catch"]]
            table = by_session(changed.assign(value=changed["difference_felt"].astype(float)))
            yield f"{data.quantity.yes_no.name}, “{data.quantity.yes}” on changes", "share", table


ANALYSIS = _Difference()
