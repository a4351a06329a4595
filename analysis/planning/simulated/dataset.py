"""Convert a simulated study to a data set that `analyse` can read.

This conversion is required for tests that are not vectorised.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from slipscale.analysis.planning.simulated.estimates import Ratings
from slipscale.analysis.reading.cleaning import empty_differences
from slipscale.analysis.reading.dataset import Dataset
from slipscale.analysis.reading.trial_tables import FACTOR
from slipscale.experiments.dataset.schema import PARTICIPANT
from slipscale.experiments.study.analysis_choices import AnalysisChoices


def simulated_dataset(
    ratings: Ratings,
    study: int,
    levels: Sequence[float],
    choices: AnalysisChoices,
    *,
    declared: bool,
    conditions: Sequence[Mapping[str, str]] = ({},),
) -> Dataset:
    """Convert one of several simulated studies to a data set.

    Parameters
    ----------
    ratings : Ratings
    study : int
        Index of the study, from 0.
    levels : sequence of float
        Amplitudes in ascending order.
    choices : AnalysisChoices
        The study's choices.
    declared : bool
        Whether participants stated the maximum of their scale.
    conditions : sequence of Mapping
        Factor levels for each condition in ``ratings``.
    """
    percent = ratings.percent[study]
    people, trials = percent.shape
    width = max(2, len(str(people)))
    names = [f"sub-{number:0{width}d}" for number in range(1, people + 1)]
    who = np.repeat(np.arange(people), trials)
    top = ratings.scale_top[study][who]
    frame = pd.DataFrame(
        {
            PARTICIPANT: pd.Categorical(np.array(names)[who]),
            "session": _label("", len(who)),
            "run": _label("01", len(who)),
            "trial": np.tile(np.arange(1.0, trials + 1), people),
            "level": np.array(levels)[ratings.amplitude[study].ravel()],
            "estimate": np.round(percent.ravel() / 100 * top, 6),
            "response_time": np.full(len(who), np.nan),
            "scale_top": top if declared else np.full(len(who), np.nan),
            "modulus": np.full(len(who), np.nan),
            "flag": _label("", len(who)),
            "timed_out": False,
            "faulty": False,
        }
    )
    which = np.broadcast_to(ratings.condition, ratings.percent.shape)[study].ravel()
    for factor in conditions[0]:
        values = np.array([each[factor] for each in conditions])
        frame[f"{FACTOR}{factor}"] = pd.Categorical(values[which])
    # Excluded participants have no rows. Participants who dropped out have no later rows.
    answered = frame[frame["estimate"].notna()].reset_index(drop=True)
    participants = answered[PARTICIPANT].cat.remove_unused_categories()
    answered = answered.assign(**{PARTICIPANT: participants})
    return Dataset(
        name="simulated",
        estimates=answered,
        answers=answered,
        differences=empty_differences(),
        participants=pd.DataFrame({PARTICIPANT: names}),
        mode="pilot",
        choices=choices,
    )


def _label(label: str, rows: int) -> pd.Categorical[str]:
    return pd.Categorical([label] * rows)


def place_of(label: str) -> int:
    """Parse a simulated participant's label; return the index, counted from 0."""
    return int(label.removeprefix("sub-")) - 1
