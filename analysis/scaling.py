"""Growth of sensation: Stevens's power law and its rivals.

All models are of the logarithm of an estimate: log y = a_i + log f(x; θ) + error, with an own
factor exp(a_i) for each participant, so that the error is proportional and the normalisation
does not matter. Fitted by least squares on participants' mean logarithms at amplitudes above 0,
where every model is defined, so that information criteria compare like with like.

=========  ==================  ============================================
model      f(x; θ)             source
=========  ==================  ============================================
power      x^β                 Stevens (1957), Psychol. Rev. 64, 153-181
threshold  (x - x0)^β          Stevens (1975), Psychophysics, ch. 1
linear     x + c               a line with an intercept
fechner    log(x / x0)         Fechner (1860); sensation 0 at threshold x0
=========  ==================  ============================================
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis.inference import FEWEST, Result, mean_with_interval, reason

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from analysis.prepared import Prepared

    Array = NDArray[np.float64]

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
        return reason(
            f"{usable} participants with estimates above zero at two or more amplitudes above 0; "
            f"{FEWEST} are needed"
        )
    return {
        "exponent": found["mean"],
        "ci95" if data.choices.confidence == 0.95 else "ci": found["ci"],  # noqa: PLR2004
        "sd": found["sd"],
        "n": found["df"] + 1,
        "points": int(table["points"].max()),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """A growth function: its logarithm, and starting points within bounds for its parameters.

    ``log_f(x, θ)`` takes stimuli above 0; ``starts(x)`` gives several θ to start from, and
    ``bounds(x)`` the lower and upper limits.
    """

    parameters: tuple[str, ...]
    log_f: Callable[[Array, Array], Array]
    starts: Callable[[Array], list[list[float]]]
    bounds: Callable[[Array], tuple[list[float], list[float]]]


def _just_below(x: Array) -> float:
    return float(x.min()) * (1 - 1e-6)


MODELS: dict[str, Growth] = {
    "power": Growth(
        parameters=("exponent",),
        log_f=lambda x, theta: theta[0] * np.log(x),
        starts=lambda _: [[1.0]],
        bounds=lambda _: ([-20.0], [20.0]),
    ),
    "threshold": Growth(
        parameters=("exponent", "threshold"),
        log_f=lambda x, theta: theta[0] * np.log(x - theta[1]),
        starts=lambda x: [[1.0, 0.0], [0.5, 0.5 * x.min()], [0.3, 0.95 * x.min()]],
        bounds=lambda x: ([-20.0, -10.0 * float(x.max())], [20.0, _just_below(x)]),
    ),
    "linear": Growth(
        parameters=("offset",),
        log_f=lambda x, theta: np.log(x + theta[0]),
        starts=lambda x: [[0.0], [-0.5 * x.min()], [2.0 * x.max()]],
        bounds=lambda x: ([-_just_below(x)], [1000.0 * float(x.max())]),
    ),
    "fechner": Growth(
        parameters=("threshold",),
        log_f=lambda x, theta: np.log(np.log(x) - theta[0]),
        starts=lambda x: [[float(np.log(x.min())) - 0.1], [float(np.log(x.min())) - 2.0]],
        bounds=lambda x: ([float(np.log(x.min())) - 50.0], [float(np.log(x.min())) - 1e-6]),
    ),
}


def fit(name: str, stimuli: Array, logs: Array) -> Result:
    """Fit one growth function to one or more participants, each with an own factor.

    Parameters
    ----------
    name : str
        A key of `MODELS`.
    stimuli : array, shape (k,)
        Above 0.
    logs : array, shape (n, k)
        Mean natural logarithms of estimates; NaN where missing.

    Returns
    -------
    dict
        ``parameters``, residual ``sd``, ``log_likelihood``, ``aic``, ``aicc`` (None where the
        points do not suffice), ``bic``, ``points``, ``estimated`` (how many numbers were fitted).
    """
    from scipy import optimize  # noqa: PLC0415

    model = MODELS[name]
    here = ~np.isnan(logs)
    factor = np.nanmean(logs, axis=1, keepdims=True)

    def residuals(theta: Array) -> Array:
        shape = np.where(here, model.log_f(stimuli, theta), np.nan)
        return np.asarray(
            ((logs - factor) - (shape - np.nanmean(shape, axis=1, keepdims=True)))[here]
        )

    fits = [
        optimize.least_squares(residuals, start, bounds=model.bounds(stimuli), x_scale="jac")
        for start in model.starts(stimuli)
    ]
    best = min(fits, key=lambda found: found.cost)
    points, people = int(here.sum()), len(logs)
    squares = max(2 * float(best.cost), 1e-300)
    estimated = len(model.parameters) + people + 1
    log_likelihood = -points / 2 * (np.log(2 * np.pi * squares / points) + 1)
    spare = points - estimated - 1
    aic = 2 * estimated - 2 * log_likelihood
    values = dict(zip(model.parameters, (float(value) for value in best.x), strict=True))
    if name == "fechner":
        values["threshold"] = float(np.exp(values["threshold"]))
    return {
        "parameters": values,
        "sd": float(np.sqrt(squares / max(points - estimated + 1, 1))),
        "log_likelihood": float(log_likelihood),
        "aic": float(aic),
        "aicc": float(aic + 2 * estimated * (estimated + 1) / spare) if spare > 0 else None,
        "bic": float(estimated * np.log(points) - 2 * log_likelihood),
        "points": points,
        "estimated": estimated,
    }


def compare(logs: pd.DataFrame) -> Result:
    """Fit every growth function to the group and rank them by the corrected Akaike criterion.

    Parameters
    ----------
    logs : DataFrame, shape (participants, stimuli)
        As for `exponents`.

    Returns
    -------
    dict
        Model -> `fit` with ``delta_aicc`` and ``weight``; under ``best`` the model of least AICc.
    """
    usable = logs.loc[:, logs.columns.to_numpy(float) > 0]
    usable = usable[usable.notna().sum(axis=1) >= 2]  # noqa: PLR2004
    stimuli = usable.columns.to_numpy(float)
    if len(usable) < FEWEST or len(stimuli) < 3:  # noqa: PLR2004
        return reason(
            f"{len(usable)} participants and {len(stimuli)} amplitudes above 0; three of each are "
            "needed to tell models apart"
        )
    fits = {name: fit(name, stimuli, usable.to_numpy(float)) for name in MODELS}
    scores = {name: found["aicc"] for name, found in fits.items() if found["aicc"] is not None}
    if not scores:
        return reason("too few points for the corrected Akaike criterion")
    least = min(scores.values())
    weights = {name: np.exp(-(score - least) / 2) for name, score in scores.items()}
    for name, found in fits.items():
        score = scores.get(name)
        found["delta_aicc"] = None if score is None else float(score - least)
        found["weight"] = float(weights.get(name, 0.0) / sum(weights.values()))
    return {"models": fits, "best": min(scores, key=lambda name: scores[name]), "n": len(usable)}


def individual_winners(trials: pd.DataFrame) -> dict[str, str | None]:
    """Return the growth function of least AICc for each participant, from single trials.

    Parameters
    ----------
    trials : DataFrame
        ``participant_id amplitude_um_pp log``; amplitudes of 0 and missing logarithms count for
        nothing.

    Returns
    -------
    dict
        Participant -> model, or None where too few trials tell models apart.
    """
    usable = trials[(trials["amplitude_um_pp"] > 0) & trials["log"].notna()]
    winners: dict[str, str | None] = {}
    for who, own in usable.groupby("participant_id", observed=True):
        stimuli, logs = own["amplitude_um_pp"].to_numpy(float), own["log"].to_numpy(float)[None, :]
        scores: dict[str, float] = {}
        # The largest model has four numbers to estimate; AICc needs six points for that.
        if len(stimuli) >= 6 and len(np.unique(stimuli)) >= 3:  # noqa: PLR2004
            found = {name: fit(name, stimuli, logs)["aicc"] for name in MODELS}
            scores = {name: aicc for name, aicc in found.items() if aicc is not None}
        winners[str(who)] = min(scores, key=lambda name: scores[name]) if scores else None
    return winners


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
