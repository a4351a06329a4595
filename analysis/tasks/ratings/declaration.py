"""Declare ratings on a visual analogue scale, or in categories."""

from __future__ import annotations

from slipscale.analysis.tasks.declared.flat_table import flat_under
from slipscale.analysis.tasks.declared.one_statistic import of_each, of_one_statistic
from slipscale.analysis.tasks.declared.session_tables import mean_by_session
from slipscale.analysis.tasks.ratings import figures, section, sentences
from slipscale.analysis.tasks.ratings.reading import TRIALS
from slipscale.analysis.tasks.ratings.statistics import RATINGS

ANALYSIS = of_one_statistic(
    "ratings",
    TRIALS,
    RATINGS,
    question="Where on a scale between two words do the {q.stimuli} lie?",
    what="a rating scale",
    title="Rating scales",
    answers=lambda found, _, q: [sentences.rating_answer(task, q) for task in found],
    sentences=sentences.rating_sentences,
    heading="Ratings on a scale",
    blocks=of_each(section.blocks),
    figures=lambda found, trials, q: {
        f"ratings_{each.task}": figures.ratings(each, trials[trials["task"] == each.task], q)
        for each in found
    },
    table=lambda found: flat_under(
        [({"task": task.task}, each) for task in found for each in task.surfaces]
    ).rename(
        columns={
            "sd": "standard_deviation",
            "at_left": "at_left_end",
            "at_right": "at_right_end",
        }
    ),
    session_tables=mean_by_session(
        TRIALS,
        "mean rating",
        "place on the line, 0 to 100, or category",
        lambda rows: rows["rating"].astype(float),
    ),
)
