"""Compute descriptive statistics of texture estimates.

A texture has no single amplitude, and a plain surface of the same maximum amplitude can feel
different. Texture estimates are therefore normalised in the same way as estimates of plain surfaces
in the same run, but do not affect this normalisation.
"""

from __future__ import annotations

import pandas as pd

from slipscale.analysis.preprocessing import normalisation
from slipscale.analysis.statistics import descriptives
from slipscale.experiments.dataset.schema import PARTICIPANT

RUN = [PARTICIPANT, "session", "run"]


def describe(
    textures: pd.DataFrame, estimates: pd.DataFrame, rule: str, standard_deviation: str
) -> pd.DataFrame:
    """Return the statistics of Table III for each texture.

    Parameters
    ----------
    textures, estimates : DataFrame
        `slipscale.analysis.reading.dataset.Dataset.textures` and ``estimates``.
    rule : str
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`. Every rule divides all
        estimates of a run by the same number.
    standard_deviation : {"sample", "population"}
        Convention for the standard deviation: division by n - 1 (sample) or by n (population).

    Returns
    -------
    table : DataFrame
        Columns ``texture``, ``n``, ``mean``, ``maximum_deviation`` and ``standard_deviation``. Rows
        are sorted by name. Runs without an estimate of a plain surface are omitted.
    """
    columns = ["texture", "n", "mean", "maximum_deviation", "standard_deviation"]
    if not len(textures) or not len(estimates):
        return pd.DataFrame(columns=columns)
    divisor = normalisation.divisors(estimates, rule).rename("divisor")
    scales = pd.concat([estimates[RUN].astype(str), divisor], axis=1)
    scales = scales.groupby(RUN)["divisor"].mean().reset_index()
    trials = textures.astype(dict.fromkeys([*RUN, "texture"], str)).merge(scales, on=RUN)
    trials["normalised"] = trials["estimate"] / trials["divisor"] * normalisation.RULES[rule].top
    means = trials.groupby([PARTICIPANT, "texture"])["normalised"].mean()
    cells = means.unstack("texture")  # noqa: PD010 - the index already exists
    found = descriptives.over_participants(cells, standard_deviation)
    return found.assign(texture=cells.columns.to_numpy())[columns]
