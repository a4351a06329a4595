"""Fit and compare growth functions: Stevens's power law and five others.

All models describe the logarithm of an estimate, log y = a_i + log f(x; θ) + error, with a separate
factor exp(a_i) for each participant. The error is therefore proportional to the estimate, and the
normalisation does not affect the result. Functions are not compared if estimates decrease with the
stimulus, because most of the functions cannot decrease. The models are fitted to participants' mean
logarithms at amplitudes above 0, where all models are defined, so that their information criteria
can be compared.

============  ==================  ============================================================
model         f(x; θ)             source
============  ==================  ============================================================
power         x^β                 Stevens (1957), Psychological Review 64, 153-181
threshold     (x - x0)^β          Stevens (1975), Psychophysics, chapter 1
linear        x + c               a line with an intercept
fechner       log(x / x0)         Fechner (1860); sensation 0 at threshold x0
ekman         1 + (x / x1)^β      Ekman (1959), Journal of Psychology 47, 343-352; a constant
                                  sensation, which the stimulus x1 doubles
naka_rushton  x^β / (x^β + xs^β)  Naka and Rushton (1966), Journal of Physiology 185, 587-599;
                                  half of the largest sensation at xs
============  ==================  ============================================================
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from slipscale.analysis.json_form import record, renamed
from slipscale.analysis.preprocessing.sufficiency import FEWEST, TINY, few
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.power_law import too_few_slopes
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, Quantity

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, slots=True, kw_only=True)
class GrowthFunction:
    """A growth function (its logarithm), with starting points and bounds for the fit.

    ``log_f(x, θ)`` requires stimuli above 0. ``starts(x)`` returns several starting points θ, and
    ``bounds(x)`` returns their lower and upper limits. ``logarithmic`` lists the parameters whose
    logarithms are used in θ.
    """

    parameters: tuple[str, ...]
    log_f: Callable[[Array, Array], Array]
    starts: Callable[[Array], list[list[float]]]
    bounds: Callable[[Array], tuple[list[float], list[float]]]
    logarithmic: tuple[str, ...] = ()

    def theta(self, parameters: Mapping[str, float]) -> Array:
        """Convert reported parameters to the vector θ for ``log_f``."""
        return np.array(
            [
                np.log(parameters[name]) if name in self.logarithmic else parameters[name]
                for name in self.parameters
            ]
        )

    def reported(self, theta: Array) -> dict[str, float]:
        """Convert θ to reported parameters, keyed by name."""
        return {
            name: float(np.exp(value) if name in self.logarithmic else value)
            for name, value in zip(self.parameters, theta, strict=True)
        }


#: Models whose AICc exceeds the smallest AICc by less than this value are not ruled out (Burnham
#: and Anderson 2002, Model Selection and Multimodel Inference, p. 70).
UNDECIDED = 2.0
#: A parameter counts as being at its search limit if moving it there lowers the log likelihood by
#: less than this value.
AT_BOUND = 1e-3
#: Stimulus parameters are searched up to a factor of about 1,000 (natural logarithm: 7) beyond the
#: presented stimuli.
OUTSIDE = 7.0


def _log(x: Array, place: float) -> float:
    """Interpolate between the smallest (``place`` = 0) and largest (``place`` = 1) log stimulus."""
    low, high = float(np.log(x.min())), float(np.log(x.max()))
    return low + place * (high - low)


def _just_below(x: Array) -> float:
    return float(x.min()) * (1 - 1e-6)


MODELS: dict[str, GrowthFunction] = {
    "power": GrowthFunction(
        parameters=("exponent",),
        log_f=lambda x, theta: theta[0] * np.log(x),
        starts=lambda _: [[1.0]],
        bounds=lambda _: ([-20.0], [20.0]),
    ),
    "threshold": GrowthFunction(
        parameters=("exponent", "threshold"),
        log_f=lambda x, theta: theta[0] * np.log(x - theta[1]),
        starts=lambda x: [[1.0, 0.0], [0.5, 0.5 * x.min()], [0.3, 0.95 * x.min()]],
        bounds=lambda x: ([-20.0, -10.0 * float(x.max())], [20.0, _just_below(x)]),
    ),
    "linear": GrowthFunction(
        parameters=("offset",),
        log_f=lambda x, theta: np.log(x + theta[0]),
        starts=lambda x: [[0.0], [-0.5 * x.min()], [2.0 * x.max()]],
        bounds=lambda x: ([-_just_below(x)], [1000.0 * float(x.max())]),
    ),
    "fechner": GrowthFunction(
        parameters=("threshold",),
        log_f=lambda x, theta: np.log(np.log(x) - theta[0]),
        starts=lambda x: [[float(np.log(x.min())) - 0.1], [float(np.log(x.min())) - 2.0]],
        bounds=lambda x: ([float(np.log(x.min())) - 50.0], [float(np.log(x.min())) - 1e-6]),
        logarithmic=("threshold",),
    ),
    "ekman": GrowthFunction(
        parameters=("exponent", "doubling_stimulus"),
        log_f=lambda x, theta: np.logaddexp(0.0, theta[0] * (np.log(x) - theta[1])),
        starts=lambda x: [[0.5, _log(x, 0.0)], [2.0, _log(x, 1.0)]],
        bounds=lambda x: ([0.0, _log(x, 0.0) - OUTSIDE], [20.0, _log(x, 1.0) + OUTSIDE]),
        logarithmic=("doubling_stimulus",),
    ),
    "naka_rushton": GrowthFunction(
        parameters=("exponent", "half_saturation"),
        log_f=lambda x, theta: -np.logaddexp(0.0, theta[0] * (theta[1] - np.log(x))),
        starts=lambda x: [[0.5, _log(x, 1.0)], [2.0, _log(x, 0.0)]],
        bounds=lambda x: ([0.0, _log(x, 0.0) - OUTSIDE], [20.0, _log(x, 1.0) + OUTSIDE]),
        logarithmic=("half_saturation",),
    ),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class GrowthFit:
    """The fit of a growth function to one or more participants.

    Parameters
    ----------
    parameters : Mapping
        Parameter values by name; thresholds and offsets are in the unit of the stimulus.
    sd : float
        Standard deviation of the residuals (natural logarithm).
    log_likelihood, aic, bic : float
        Computed for independent normal residuals.
    aicc : float or None
        Corrected Akaike criterion; None if there are too few points.
    points : int
        Number of mean logarithms to which the function was fitted.
    estimated : int
        Number of estimated parameters.
    at_bound : tuple of str
        Parameters that the data do not determine: a limit of the search range fits equally well.
    """

    parameters: Mapping[str, float]
    sd: float
    log_likelihood: float
    aic: float
    aicc: float | None
    bic: float
    points: int
    estimated: int
    at_bound: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RankedFit:
    """Fit of a growth function, with its AICc relative to the best fit.

    Parameters
    ----------
    fit : GrowthFit
        Fit of one growth function.
    delta_aicc : float or None
        AICc minus the smallest AICc; None if AICc is not defined.
    weight : float
        Akaike weight; 0 if AICc is not defined.
    """

    fit: GrowthFit
    delta_aicc: float | None
    weight: float

    def json_form(self) -> Mapping[str, object]:
        """Return a dictionary with the keys used in the JSON output."""
        return {**record(self.fit), **renamed(self, fit="")}


@dataclass(frozen=True, slots=True, kw_only=True)
class GrowthComparison:
    """A comparison of growth functions for the same participants.

    Parameters
    ----------
    models : Mapping
        Fits, keyed by the names in `MODELS`.
    best : str
        The model with the smallest AICc.
    n : int
        Number of participants.
    """

    models: Mapping[str, RankedFit]
    best: str
    n: int

    @property
    def undecided(self) -> tuple[str, ...]:
        """Models, other than the best, that the data do not rule out; see `UNDECIDED`."""
        return tuple(
            name
            for name, model in self.models.items()
            if name != self.best and model.delta_aicc is not None and model.delta_aicc < UNDECIDED
        )


def fit(name: str, stimuli: Array, logs: Array) -> GrowthFit:
    """Fit one growth function to one or more participants, each with a separate scale factor.

    Parameters
    ----------
    name : str
        A key of `MODELS`.
    stimuli : array, shape (k,)
        Stimuli above 0.
    logs : array, shape (n, k)
        Mean natural logarithms of estimates, with NaN for missing values.
    """
    from scipy import optimize

    model = MODELS[name]
    here = ~np.isnan(logs)
    centred = logs - np.nanmean(logs, axis=1, keepdims=True)
    # Participants with the same stimuli have the same curve, so only their mean and number are
    # needed.
    patterns, whose, people_of = np.unique(here, axis=0, return_inverse=True, return_counts=True)
    means = np.array([centred[whose == place].mean(axis=0) for place in range(len(patterns))])
    weights = np.sqrt(people_of)[:, None]
    around = float(np.nansum((centred - means[whose]) ** 2))

    def residuals(theta: Array) -> Array:
        shape = np.where(patterns, model.log_f(stimuli, theta), np.nan)
        shape -= np.nanmean(shape, axis=1, keepdims=True)
        return np.asarray((weights * (means - shape))[patterns])

    fits = [
        optimize.least_squares(residuals, start, bounds=model.bounds(stimuli), x_scale="jac")
        for start in model.starts(stimuli)
    ]
    best = min(fits, key=lambda found: found.cost)
    points, people = int(here.sum()), len(logs)
    squares = max(2 * float(best.cost) + around, 1e-300)
    estimated = len(model.parameters) + people + 1
    log_likelihood = -points / 2 * (np.log(2 * np.pi * squares / points) + 1)
    spare = points - estimated - 1

    def _costs_nothing(place: int, limits: list[float]) -> bool:
        """Return whether moving one parameter to its limit makes the fit no worse."""
        theta = best.x.copy()
        theta[place] = limits[place]
        left = residuals(theta)
        worse = (float(left @ left) + around) / squares
        return bool(points / 2 * np.log(max(worse, 1.0)) < AT_BOUND)

    aic = 2 * estimated - 2 * log_likelihood
    return GrowthFit(
        parameters=model.reported(best.x),
        sd=float(np.sqrt(squares / max(points - estimated + 1, 1))),
        log_likelihood=float(log_likelihood),
        aic=float(aic),
        aicc=float(aic + 2 * estimated * (estimated + 1) / spare) if spare > 0 else None,
        bic=float(estimated * np.log(points) - 2 * log_likelihood),
        points=points,
        estimated=estimated,
        at_bound=tuple(
            parameter
            for place, parameter in enumerate(model.parameters)
            if any(_costs_nothing(place, limits) for limits in model.bounds(stimuli))
        ),
    )


def compare(
    logs: pd.DataFrame, quantity: Quantity = PLATE_AMPLITUDE
) -> GrowthComparison | NotComputed:
    """Fit every growth function to the group and rank them by the corrected Akaike criterion.

    Parameters
    ----------
    logs : DataFrame, shape (participants, stimuli)
        Mean natural logarithms of estimates. Only stimuli above 0 are used.
    quantity : Quantity
        Quantity of the stimuli.
    """
    usable = logs.loc[:, logs.columns.to_numpy(float) > 0]
    usable = usable[usable.notna().sum(axis=1) >= 2]  # noqa: PLR2004
    stimuli = usable.columns.to_numpy(float)
    if len(stimuli) < 3:  # noqa: PLR2004 - models have up to two shape parameters
        return NotComputed(few(f"{quantity.levels} above 0", len(stimuli), 3))
    if len(usable) < FEWEST:
        return too_few_slopes(len(usable), quantity)
    if (np.nanmax(usable, axis=1) - np.nanmin(usable, axis=1) <= TINY).all():
        return NotComputed("the estimates of each participant are all the same")
    fits = {name: fit(name, stimuli, usable.to_numpy(float)) for name in MODELS}
    if fits["power"].parameters["exponent"] < 0:
        return NotComputed(
            f"estimates decrease as {quantity.name} increases, but growth functions can only "
            "increase"
        )
    scores = {name: found.aicc for name, found in fits.items() if found.aicc is not None}
    if not scores:
        return NotComputed("there are too few points for the corrected Akaike criterion")
    least = min(scores.values())
    weights = {name: np.exp(-(score - least) / 2) for name, score in scores.items()}
    return GrowthComparison(
        models={
            name: RankedFit(
                fit=found,
                delta_aicc=float(scores[name] - least) if name in scores else None,
                weight=float(weights.get(name, 0.0) / sum(weights.values())),
            )
            for name, found in fits.items()
        },
        best=min(scores, key=lambda name: scores[name]),
        n=len(usable),
    )
