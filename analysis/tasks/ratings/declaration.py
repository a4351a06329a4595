"""Ratings on a visual analogue scale, declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.analysis.tasks.declaring import run_trials, tables_of
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.tasks.ratings import figures, section, sentences, table
from slipscale.analysis.tasks.ratings.reading import TRIALS
from slipscale.analysis.tasks.ratings.statistics import RATINGS
from slipscale.analysis.tasks.session_tables import mean_by_session

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.figure import Figure

    from slipscale.analysis.result import Analysis


def _answers(analysis: Analysis) -> list[str]:
    found = analysis.inference.found(RATINGS) or ()
    return [sentences.rating_answer(task) for task in found]


def _sentences(analysis: Analysis) -> Mapping[str, list[str]]:
    found, level = analysis.inference[RATINGS], analysis.dataset.choices.confidence
    return {"Visual analogue scale": sentences.rating_sentences(found, level)}


def _figures(analysis: Analysis) -> Mapping[str, Figure]:
    trials = analysis.dataset.of(TRIALS)
    return {
        f"ratings_{each.task}": figures.ratings(each, trials[trials["task"] == each.task])
        for each in analysis.inference.found(RATINGS) or ()
    }


ANALYSIS = TaskAnalysis(
    name="ratings",
    trials=TRIALS,
    statistics=(RATINGS,),
    questions=lambda analysis: (
        ["Where on a line between two words do the surfaces lie?"]
        if analysis.inference.found(RATINGS)
        else []
    ),
    design=run_trials(TRIALS, "a visual analogue scale"),
    answers=_answers,
    sentences=_sentences,
    sections=(section.ratings,),
    figures=_figures,
    tables=tables_of("ratings", RATINGS, table.rating_table),
    session_tables=mean_by_session(
        TRIALS,
        "mean rating",
        "place on the line, 0 to 100",
        lambda rows: rows["rating"].astype(float),
    ),
)
