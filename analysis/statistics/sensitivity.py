"""Compare results under every applicable normalisation rule."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from slipscale.analysis.preprocessing.normalisation import RULES, cell_means, normalise_by_all
from slipscale.stimuli.quantity import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleSummary:
    """Means and standard deviations under one normalisation rule.

    Parameters
    ----------
    rule : str
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`.
    used : bool
        Whether the main analysis uses this rule.
    unit : str
        Unit of the means and standard deviations.
    mean, sd_sample : Mapping
        Mean and standard deviation across participants, keyed by amplitude in µm peak to peak.
    """

    rule: str
    used: bool
    unit: str
    mean: Mapping[float, float]
    sd_sample: Mapping[float, float]


def sensitivity(trials: pd.DataFrame, used: str, quantity: Quantity) -> tuple[RuleSummary, ...]:
    """Return the means and standard deviations of Table III for each possible normalisation rule.

    The exponent and all within-participant tests on logarithms do not depend on the rule.
    """
    rows = []
    normalised = normalise_by_all(trials)
    # Grouping trials into cells takes longer than averaging, so it is done once for all rules.
    means = cell_means(trials.assign(**normalised), list(normalised))
    for name in normalised:
        cells = pd.DataFrame(means[name])
        amplitudes = cells.columns.to_numpy(float).tolist()
        rows.append(
            RuleSummary(
                rule=name,
                used=name == used,
                unit=RULES[name].unit.format(q=quantity),
                mean=dict(zip(amplitudes, cells.mean().tolist(), strict=True)),
                sd_sample=dict(zip(amplitudes, cells.std(ddof=1).tolist(), strict=True)),
            )
        )
    return tuple(rows)
