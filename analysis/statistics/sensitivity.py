"""Compare the same estimates under every normalisation rule that the data allow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from slipscale.analysis.preprocessing.normalisation import RULES, cell_means, normalise_by_all

if TYPE_CHECKING:
    from collections.abc import Mapping

    from slipscale.stimuli.quantity import Quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class RuleSummary:
    """Means and spreads under one rule.

    Parameters
    ----------
    rule : str
        A key of `slipscale.analysis.preprocessing.normalisation.RULES`.
    used : bool
        Whether it is the rule used by the analysis.
    unit : str
        Unit of mean and standard deviation.
    mean, sd_sample : Mapping
        Amplitude (µm peak to peak) -> value over participants.
    """

    rule: str
    used: bool
    unit: str
    mean: Mapping[float, float]
    sd_sample: Mapping[float, float]


def sensitivity(trials: pd.DataFrame, used: str, quantity: Quantity) -> tuple[RuleSummary, ...]:
    """Return Table III's means and spreads under every rule that the data allow.

    The exponent and every within-participant test on logarithms are the same under all of them.
    """
    rows = []
    normalised = normalise_by_all(trials)
    # Trials are sorted into cells once for all rules, because that takes longer than the means.
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
