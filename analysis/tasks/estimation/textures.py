"""Describe estimates of textures, separately from the statistics across amplitudes.

A texture has no single amplitude: its maximum may equal that of a plain surface that feels quite
different. Textures therefore do not affect the scale; they are normalised with the scale of the
plain surfaces in the same run.
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
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`: each is one division
        within a run.
    standard_deviation : {"sample", "population"}
        Divide by n - 1 or by n.

    Returns
    -------
    DataFrame
        ``texture n mean maximum_deviation standard_deviation``, sorted by name; empty without
        textures. A run without an estimate of a plain surface has no scale and is omitted.
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
    cells = means.unstack("texture")  # noqa: PD010 - the index is already made
    found = descriptives.over_participants(cells, standard_deviation)
    return found.assign(texture=cells.columns.to_numpy())[columns]
