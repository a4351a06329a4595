"""Fit a scale of perceived differences by maximum likelihood difference scaling.

The probability of judging one of two differences as larger is modelled as a probit function of the
scale values, the first of which is 0 (Maloney and Yang 2003, Journal of Vision 3(8):5; Knoblauch
and Maloney 2008, Journal of Statistical Software 25(2)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.faults import UserError

Array = npt.NDArray[np.float64]

#: Largest scale, in units of the noise; larger differences would never be misjudged.
LARGEST = 30.0
#: Size of the step at which Fisher scoring stops, and largest number of steps.
PRECISION, ITERATIONS = 1e-10, 50
#: Smallest distance of probabilities from 0 and 1, which keeps variances above rounding errors.
EDGE = 1e-12
#: Intervals are not reported if the fit fails for more than this proportion of simulated data sets.
MOST_FAILED = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class DifferenceScale:
    """A scale of perceived differences between surfaces.

    Parameters
    ----------
    values : tuple of float
        Scale values, from 0 for the first surface to 1 for the last.
    intervals : tuple of ConfidenceInterval or None
        Bootstrap percentile intervals, one per surface; None for the first and last surface.
    noise : float
        Standard deviation of a judgement (sigma), as a fraction of the whole scale.
    noise_interval : ConfidenceInterval
        Bias-corrected bootstrap percentile interval of the noise.
    log_likelihood : float
        Log likelihood of the fit.
    answers, simulations : int
        Number of answers, and number of simulated data sets.
    """

    values: tuple[float, ...]
    intervals: tuple[ConfidenceInterval | None, ...]
    noise: float
    noise_interval: ConfidenceInterval
    log_likelihood: float
    answers: int
    simulations: int


def triads_as_quadruples(triads: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Convert triads (a, b, c), which compare a-b with b-c, to quadruples (a, b, b, c)."""
    surfaces = np.asarray(triads, int)
    if surfaces.ndim != 2 or surfaces.shape[1] != 3:  # noqa: PLR2004 - three surfaces
        raise UserError("triads: expected three surfaces per row")
    return surfaces[:, [0, 1, 1, 2]]


def difference_scale(
    quadruples: npt.ArrayLike,
    second_larger: npt.ArrayLike,
    *,
    confidence: float = 0.95,
    simulations: int = 1000,
    seed: int = 2008,
) -> DifferenceScale | NotComputed:
    """Fit a difference scale, with intervals from a parametric bootstrap.

    Parameters
    ----------
    quadruples : array_like of int, shape (trials, 4)
        Ranks of the surfaces a, b, c and d (0 for the weakest), where the pair (a, b) is compared
        with the pair (c, d). The order within a pair is ignored, because only the size of a
        difference matters.
    second_larger : array_like of bool, shape (trials,)
        Whether the difference between c and d was judged to be larger.
    simulations : int
        Number of data sets that are simulated from the fit and fitted again.

    Raises
    ------
    UserError
        The arrays have wrong shapes, or ranks are negative or not consecutive.
    """
    surfaces, larger = np.asarray(quadruples, int), np.asarray(second_larger, float)
    if surfaces.ndim != 2 or surfaces.shape[1] != 4 or len(surfaces) != len(larger):  # noqa: PLR2004
        raise UserError("quadruples: expected four surfaces and one answer per trial")
    if len(surfaces) and surfaces.min() < 0:
        raise UserError("quadruples: ranks of surfaces must be 0 or greater")
    count = int(surfaces.max(initial=0)) + 1
    if count < FEWEST:
        return NotComputed(few("surfaces", count))
    if missing := sorted(set(range(count)) - set(surfaces.ravel().tolist())):
        raise UserError(f"quadruples: surface {missing[0]} was never presented")
    # The model is fitted to proportions of trials with the same four surfaces.
    same, place = np.unique(_design(surfaces, count), axis=0, return_inverse=True)
    trials = np.bincount(place).astype(float)
    yes = np.bincount(place, weights=larger).astype(float)
    found = _fit(same, yes, trials)
    if isinstance(found, NotComputed):
        return found
    scale, share = found
    drawn = np.random.default_rng(seed).binomial(
        trials.astype(int), share, size=(simulations, len(trials))
    )
    again = _likeliest(same, drawn.astype(float), trials)
    usable = again[_why_no_scale(again) == ""]
    if len(usable) < (1 - MOST_FAILED) * simulations:
        return NotComputed(
            "there are too few answers for intervals: no scale could be estimated from "
            f"{simulations - len(usable)} of {simulations} simulated data sets"
        )
    return _result(scale, usable, (same, yes, trials, share), confidence, simulations)


def _design(surfaces: npt.NDArray[np.int64], count: int) -> Array:
    """Return the design matrix of the scale values, shape (trials, surfaces - 1)."""
    first, second = np.sort(surfaces[:, :2], axis=1), np.sort(surfaces[:, 2:], axis=1)
    rows = np.arange(len(surfaces))
    design = np.zeros((len(surfaces), count))
    for column, weight in (
        (second[:, 1], 1),
        (second[:, 0], -1),
        (first[:, 1], -1),
        (first[:, 0], 1),
    ):
        np.add.at(design, (rows, column), weight)
    return design[:, 1:]


def _fit(design: Array, yes: Array, trials: Array) -> tuple[Array, Array] | NotComputed:
    """Return scale values in units of the noise, and predicted probabilities for all trials."""
    from scipy.special import ndtr

    if np.linalg.matrix_rank(design) < design.shape[1]:
        return NotComputed("the compared differences do not connect all surfaces on one scale")
    values = _likeliest(design, yes[None], trials)
    if why := str(_why_no_scale(values)[0]):
        return NotComputed(why)
    return values[0], np.asarray(ndtr(design @ values[0, 1:]))


def _likeliest(design: Array, yes: Array, trials: Array) -> Array:
    """Fit scale values to several data sets by Fisher scoring. The shape is (sets, surfaces).

    The likelihood has at most one maximum. Without a maximum, scale values grow beyond `LARGEST`.

    Parameters
    ----------
    design : array, shape (kinds of trial, surfaces - 1)
    yes : array, shape (sets, kinds of trial)
    trials : array, shape (kinds of trial,)
    """
    from scipy.special import ndtr

    values = np.zeros((len(yes), design.shape[1]))
    going = np.arange(len(yes))
    for _ in range(ITERATIONS):
        z = values[going] @ design.T
        p = np.clip(ndtr(z), EDGE, 1 - EDGE)
        density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
        weight = density / (p * (1 - p))
        score = ((yes[going] - trials * p) * weight) @ design
        information = np.einsum("sk,kp,kq->spq", trials * density * weight, design, design)
        information[:, range(design.shape[1]), range(design.shape[1])] += EDGE
        step = np.linalg.solve(information, score[:, :, None])[:, :, 0]
        values[going] += step
        most = np.abs(values[going]).max(axis=1)
        going = going[(np.abs(step).max(axis=1) > PRECISION) & (most <= LARGEST)]
        if not len(going):
            break
    values[going] = np.inf  # the fits to these data sets did not converge
    return np.concatenate([np.zeros((len(yes), 1)), values], axis=1)


def _why_no_scale(values: Array) -> npt.NDArray[np.str_]:
    """Return, for each data set, the reason why it yields no scale, or "" if it yields one."""
    return np.select(
        [~(np.abs(values).max(axis=1) <= LARGEST), values[:, -1] <= 0],
        [
            "the answers contain no errors, so the noise has no lower limit",
            "the strongest surface seems no stronger than the weakest",
        ],
        "",
    )


def _result(
    scale: Array,
    simulated: Array,
    data: tuple[Array, Array, Array, Array],
    confidence: float,
    simulations: int,
) -> DifferenceScale:
    from scipy.special import xlogy

    _, yes, trials, share = data
    tails = [50 * (1 - confidence), 50 * (1 + confidence)]
    # The unit of a scale is its maximum, in simulated data sets as well.
    low, high = np.percentile(simulated / simulated[:, -1:], tails, axis=0)
    noise = 1 / scale[-1]
    # With few answers, fits overestimate discrimination. The fits to simulated answers show by how
    # much, so the same factor corrects the interval.
    noise_low, noise_high = noise**2 / np.percentile(1 / simulated[:, -1], tails[::-1])
    inner = [
        ConfidenceInterval(float(a), float(b), confidence)
        for a, b in zip(low[1:-1], high[1:-1], strict=True)
    ]
    return DifferenceScale(
        values=tuple(float(value) for value in scale / scale[-1]),
        intervals=(None, *inner, None),
        noise=float(noise),
        noise_interval=ConfidenceInterval(float(noise_low), float(noise_high), confidence),
        log_likelihood=float((xlogy(yes, share) + xlogy(trials - yes, 1 - share)).sum()),
        answers=int(trials.sum()),
        simulations=simulations,
    )
