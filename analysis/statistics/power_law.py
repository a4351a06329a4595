"""Growth of sensation: exponents, of participants and of the group; amplitude and friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.preprocessing.sufficiency import FEWEST, few
from analysis.statistics.growth_models import MODELS, compare, individual_winners
from analysis.statistics.omnibus import Result, interval_name, mean_with_interval, reason

if TYPE_CHECKING:
    from analysis.preprocessing.log_transform import Prepared

#: A predicted reduction of friction below this is the rounding of none.
NO_REDUCTION = 1e-9
#: Individual model comparisons are listed for studies up to this many participants.
INDIVIDUALS_AT_MOST = 200


def exponents(logs: pd.DataFrame) -> pd.DataFrame:
    """Return each participant's power function by least squares in log-log coordinates.

    Parameters
    ----------
    logs : DataFrame, shape (participants, stimuli)
        Mean natural logarithms of estimates; columns are positive stimulus values (µm peak to
        peak, or a friction reduction). Missing cells are allowed; columns not above 0 are left
        out.

    Returns
    -------
    DataFrame
        Index as ``logs``; ``exponent intercept points``; NaN with fewer than two points.
    """
    usable = logs.loc[:, logs.columns.to_numpy(float) > 0]
    y = usable.to_numpy(float)
    x = np.where(np.isnan(y), np.nan, np.log(usable.columns.to_numpy(float)))
    points = np.sum(~np.isnan(y), axis=1)
    # Closed form of the regression line, all participants at once: missing cells count for none.
    enough = points >= 2  # noqa: PLR2004
    slope = np.full(len(y), np.nan)
    intercept = np.full(len(y), np.nan)
    if enough.any():
        xs, ys = x[enough], y[enough]
        x_mean = np.nanmean(xs, axis=1, keepdims=True)
        y_mean = np.nanmean(ys, axis=1, keepdims=True)
        slope[enough] = np.nansum((xs - x_mean) * (ys - y_mean), axis=1) / np.nansum(
            (xs - x_mean) ** 2, axis=1
        )
        intercept[enough] = y_mean[:, 0] - slope[enough] * x_mean[:, 0]
    return pd.DataFrame(
        {"exponent": slope, "intercept": intercept, "points": points}, index=logs.index
    )


def power_law(data: Prepared) -> Result:
    """Return the group's exponent: the mean of participants' slopes, with Student's interval."""
    if data.refused:
        return reason(data.zero_sentence)
    table = exponents(data.logs)
    found = mean_with_interval(table["exponent"].to_numpy(float), data.choices.confidence)
    if "reason" in found:
        usable = int(table["exponent"].notna().sum())
        if usable >= FEWEST:
            return found
        return reason(few("participants with estimates above zero at two amplitudes", usable))
    return {
        "exponent": found["mean"],
        interval_name(data.choices.confidence): found["ci"],
        "sd": found["sd"],
        "n": found["df"] + 1,
        "points": int(table["points"].max()),
    }


def growth(data: Prepared) -> Result:
    """Compare growth functions against amplitude and predicted friction, and for participants."""
    if data.refused:
        return reason(data.zero_sentence)
    found = compare(data.logs)
    if "reason" in found:
        return found
    against: dict[str, Any] = {
        "amplitude": found,
        "friction": against_friction(data.logs, data.choices.confidence),
    }
    if len(data.logs) <= INDIVIDUALS_AT_MOST:
        winners = individual_winners(data.trials)
        against["individual"] = {
            "best": {name: sum(w == name for w in winners.values()) for name in MODELS},
            "undecided": sum(w is None for w in winners.values()),
            "participants": winners,
        }
    else:
        against["individual"] = reason(
            f"listed for studies of up to {INDIVIDUALS_AT_MOST} participants"
        )
    return against


def predicted_reduction(amplitude_um_pp: float) -> float:
    """Return the reduction of friction, 1 - µ'/µ, that the film predicts for an amplitude.

    Reynolds' equation (3) in full and eq. (15), at the working point of the paper's Section IV
    (h_r = 0.6 µm, 30.5 kHz) and 0.5 N; see `VirtualSurface.predicted_relative_friction`.
    """
    from stimuli.surface import VirtualSurface  # noqa: PLC0415

    return 1.0 - VirtualSurface(amplitude_um_pp=amplitude_um_pp).predicted_relative_friction()


def against_friction(logs: pd.DataFrame, confidence: float = 0.95) -> Result:
    """Compare growth functions against the reduction of friction that the film predicts.

    Parameters
    ----------
    logs : DataFrame, shape (participants, amplitudes)
        As for `exponents`; amplitudes whose prediction is no reduction are left out.
    confidence : float
        Of the exponent's interval.
    """
    amplitudes = logs.columns.to_numpy(float)
    reductions = np.array([predicted_reduction(float(value)) for value in amplitudes])
    above = reductions > NO_REDUCTION
    if len(np.unique(reductions[above])) < above.sum():
        return reason("two amplitudes have the same predicted friction")
    table = logs.loc[:, above].set_axis(reductions[above], axis=1)
    found = compare(table)
    if "reason" not in found:
        slopes = exponents(table)["exponent"].to_numpy(float)
        found["exponent"] = mean_with_interval(slopes, confidence)
        found["reduction"] = {
            f"{a:g}": float(r) for a, r in zip(amplitudes, reductions, strict=True)
        }
    return found
