"""Ratings on a visual analogue scale, declared."""

from __future__ import annotations

from slipscale.analysis.tasks.declaring import of_one_statistic
from slipscale.analysis.tasks.ratings import figures, section, sentences, table
from slipscale.analysis.tasks.ratings.reading import TRIALS
from slipscale.analysis.tasks.ratings.statistics import RATINGS
from slipscale.analysis.tasks.session_tables import mean_by_session

ANALYSIS = of_one_statistic(
    "ratings",
    TRIALS,
    RATINGS,
    question="Where on a line between two words do the surfaces lie?",
    what="a visual analogue scale",
    title="Visual analogue scale",
    answers=lambda found, _: [sentences.rating_answer(task) for task in found],
    sentences=sentences.rating_sentences,
    section=section.ratings,
    figures=lambda found, trials: {
        f"ratings_{each.task}": figures.ratings(each, trials[trials["task"] == each.task])
        for each in found
    },
    table=table.rating_table,
    session_tables=mean_by_session(
        TRIALS,
        "mean rating",
        "place on the line, 0 to 100",
        lambda rows: rows["rating"].astype(float),
    ),
)
