"""Fit Stevens's power law to each participant and to the group."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from slipscale.analysis.json_form import renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval, key_of
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    from slipscale.analysis.preprocessing.log_transform import Prepared


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerLaw:
    """The exponent of the group's power function.

    Parameters
    ----------
    exponent : float
        Mean of participants' exponents.
    interval : ConfidenceInterval
        t-based interval across participants.
    sd : float
        Standard deviation of participants' exponents (n - 1).
    n : int
        Number of participants with a fitted exponent.
    points : int
        Largest number of amplitudes above 0 that were used for a participant's fit.
    """

    exponent: float
    interval: ConfidenceInterval
    sd: float
    n: int
    points: int

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return renamed(self, interval=key_of(self.interval))


def exponents(logs: pd.DataFrame) -> pd.DataFrame:
    """Fit each participant's power function by least squares in log-log coordinates.

    Parameters
    ----------
    logs : DataFrame, shape (participants, stimuli)
        Mean natural logarithms of estimates. The column labels are stimulus values (µm peak to
        peak, or a friction reduction). Columns whose value is not above 0 are omitted. Cells may be
        missing.

    Returns
    -------
    DataFrame
        One row per participant, with the index of ``logs`` and the columns ``exponent``,
        ``intercept`` and ``points`` (number of points in the fit). Exponents and intercepts are NaN
        with fewer than two points.
    """
    usable = logs.loc[:, logs.columns.to_numpy(float) > 0]
    lines = fit_lines(np.log(usable.columns.to_numpy(float)), usable.to_numpy(float))
    return pd.DataFrame(
        {"exponent": lines.slope, "intercept": lines.intercept, "points": lines.points},
        index=logs.index,
    )


def power_law(data: Prepared) -> PowerLaw | NotComputed:
    """Return the group exponent: the mean of participants' slopes, with a t-based interval."""
    if data.refused:
        return NotComputed(data.zero_sentence)
    return power_law_of(data.logs, data.choices.confidence, data.quantity)


def too_few_slopes(usable: int, quantity: Quantity) -> NotComputed:
    """Return why no exponent was computed from too few participants with a slope."""
    return NotComputed(
        few(f"participants with estimates above zero at two {quantity.levels} above 0", usable)
    )


def power_law_of(
    logs: pd.DataFrame, confidence: float, quantity: Quantity = PLATE_AMPLITUDE
) -> PowerLaw | NotComputed:
    """Return the group exponent for a table of mean logarithms (see `exponents`)."""
    table = exponents(logs)
    found = mean_over_participants(table["exponent"].to_numpy(float), confidence)
    if isinstance(found, NotComputed):
        usable = int(table["exponent"].notna().sum())
        if usable >= FEWEST:
            return found
        return too_few_slopes(usable, quantity)
    return PowerLaw(
        exponent=found.mean,
        interval=found.interval,
        sd=found.sd,
        n=found.df + 1,
        points=int(table["points"].max()),
    )
