"""Scale surfaces from paired comparisons.

In the Bradley-Terry model (1952, Biometrika 39, 324-345), the difference between two scale values
is the log odds of a choice. In Thurstone's case V (1927, Psychological Review 34, 273-286), the
difference is the probit of the probability of a choice.

Firth's correction multiplies the likelihood by the square root of the determinant of the
information matrix (Firth 1993, Biometrika 80, 27-38). All scale values are then finite, even if a
surface was never chosen (Kosmidis and Firth 2021, Biometrika 108, 71-82), and the first-order bias
is removed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.protocol_parts.adaptive.curves import CURVES, Curve
from slipscale.faults import UserError

Array = npt.NDArray[np.float64]
Model = Literal["Bradley-Terry", "Thurstone V"]

#: Distribution function, and derivative of the log density at z, where p is the distribution at z.
MODELS: dict[Model, tuple[Curve, Callable[[Array, Array], Array]]] = {
    "Bradley-Terry": (CURVES["logistic"], lambda _z, p: 1 - 2 * p),
    "Thurstone V": (CURVES["normal"], lambda z, _p: -z),
}

#: Smallest number of participants for which intervals account for correlated answers.
FEWEST_CLUSTERS = 3
#: Smallest distance of probabilities from 0 and 1, which keeps variances above rounding errors.
EDGE = 1e-12
#: Step size at which the search has converged, and largest number of steps.
PRECISION, ITERATIONS = 1e-10, 500


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleTest:
    """Goodness-of-fit test of a scale, based on the deviance."""

    deviance: float
    df: int
    p: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonScale:
    """Scale values of surfaces, estimated from paired comparisons.

    Parameters
    ----------
    model : {"Bradley-Terry", "Thurstone V"}
        Model of choices. The unit of the scale is natural log odds (Bradley-Terry) or the standard
        deviation of a difference (Thurstone).
    values : tuple of float
        Scale values of the surfaces; their sum is 0.
    intervals : tuple of ConfidenceInterval
        Confidence intervals of the scale values.
    covariance : tuple of tuple of float
        Covariance matrix of the scale values.
    fit : ScaleTest or NotComputed
        Goodness-of-fit test, which assumes independent answers.
    answers, participants : int
        Counts of answers and participants.
    """

    model: Model
    values: tuple[float, ...]
    intervals: tuple[ConfidenceInterval, ...]
    covariance: tuple[tuple[float, ...], ...]
    fit: ScaleTest | NotComputed
    answers: int
    participants: int


def checked_choices(chosen: npt.ArrayLike) -> Array:
    """Return counts with shape (participants, surfaces, surfaces); raise `UserError` if invalid.

    Parameters
    ----------
    chosen : array_like, shape (surfaces, surfaces) or (participants, surfaces, surfaces)
        Number of times that the row's surface was chosen over the column's surface.
    """
    counts = np.asarray(chosen, float)
    counts = counts[None] if counts.ndim == 2 else counts  # noqa: PLR2004 - a single table
    if counts.ndim != 3 or counts.shape[1] != counts.shape[2] or counts.shape[1] < 2:  # noqa: PLR2004
        raise UserError("choices: expected a square table of at least two surfaces")
    if not np.isfinite(counts).all() or np.any(counts < 0) or np.any(counts != np.round(counts)):
        raise UserError("choices: expected whole numbers of 0 or more")
    if np.any(np.diagonal(counts, axis1=1, axis2=2)):
        raise UserError("choices: a surface was compared with itself")
    return counts


def bradley_terry(chosen: npt.ArrayLike, confidence: float = 0.95) -> ComparisonScale | NotComputed:
    """Return the Bradley-Terry scale with Firth's correction.

    Parameters
    ----------
    chosen : array_like
        See `checked_choices`. If counts of at least three participants are given separately,
        intervals account for correlated answers from the same participant (sandwich estimator, t
        quantiles).
    """
    return _scale("Bradley-Terry", checked_choices(chosen), confidence)


def thurstone(chosen: npt.ArrayLike, confidence: float = 0.95) -> ComparisonScale | NotComputed:
    """Return Thurstone's case V scale with Firth's correction; see `bradley_terry`."""
    return _scale("Thurstone V", checked_choices(chosen), confidence)


class _Fit(NamedTuple):
    """Scale values, predicted probabilities (row over column), and covariance matrix."""

    values: Array
    p: Array
    relative_density: Array
    covariance: Array


def _likeliest(model: Model, pooled: Array) -> _Fit | NotComputed:
    """Maximise the penalised likelihood by Fisher scoring."""
    from scipy.sparse.csgraph import connected_components

    if connected_components(pooled, directed=False)[0] > 1:
        return NotComputed(
            "some surfaces were never compared, directly or indirectly, with the others"
        )
    curve, log_density_slope = MODELS[model]
    trials, values = pooled + pooled.T, np.zeros(len(pooled))
    for _ in range(ITERATIONS):
        z = values[:, None] - values[None, :]
        p = np.clip(curve.distribution(z), EDGE, 1 - EDGE)
        relative = np.asarray(curve.density(z) / (p * (1 - p)))
        weight = trials * relative * curve.density(z)
        # The information matrix is a graph Laplacian, and its pseudo-inverse is the covariance of
        # values that sum to 0. The null space consists of equal values. An eigenvalue cut-off could
        # miss the null space if choices are nearly certain.
        laplacian = np.diag(weight.sum(axis=1)) - weight
        equal = np.full_like(laplacian, np.trace(laplacian) / len(laplacian) ** 2)
        undetermined = 1 / (len(laplacian) ** 2 * equal)
        covariance = np.asarray(np.linalg.inv(laplacian + equal) - undetermined, np.float64)
        own = np.diagonal(covariance)
        leverage = weight * (own[:, None] + own[None, :] - 2 * covariance)
        prior = leverage * (log_density_slope(z, p) - relative * (1 - 2 * p) / 2)
        step = covariance @ ((pooled - trials * p) * relative + prior).sum(axis=1)
        longest = float(np.abs(step).max())
        if longest < PRECISION:
            return _Fit(values, p, relative, covariance)
        values = values + step / max(longest, 1.0)
    return NotComputed(f"the scale did not converge after {ITERATIONS} iterations")


def _scale(model: Model, counts: Array, confidence: float) -> ComparisonScale | NotComputed:
    from scipy import stats

    found = _likeliest(model, counts.sum(axis=0))
    if isinstance(found, NotComputed):
        return found
    covariance, participants = found.covariance, len(counts)
    quantile = float(stats.norm.ppf((1 + confidence) / 2))
    # If all participants made the same choices, answers are treated as independent.
    if participants >= FEWEST_CLUSTERS and np.ptp(counts, axis=0).any():
        trials = counts + counts.transpose(0, 2, 1)
        scores = ((counts - trials * found.p) * found.relative_density).sum(axis=2)
        spread = scores.T @ scores * participants / (participants - 1)
        covariance = covariance @ spread @ covariance
        quantile = float(stats.t.ppf((1 + confidence) / 2, participants - 1))
    half = quantile * np.sqrt(np.maximum(np.diagonal(covariance), 0))
    return ComparisonScale(
        model=model,
        values=tuple(map(float, found.values)),
        intervals=tuple(
            ConfidenceInterval(float(value - width), float(value + width), confidence)
            for value, width in zip(found.values, half, strict=True)
        ),
        covariance=tuple(tuple(map(float, row)) for row in covariance),
        fit=_test(counts.sum(axis=0), found.p),
        answers=int(counts.sum()),
        participants=participants,
    )


def _test(pooled: Array, p: Array) -> ScaleTest | NotComputed:
    from scipy import stats
    from scipy.special import xlogy

    trials = pooled + pooled.T
    df = int((np.triu(trials, k=1) > 0).sum()) - (len(pooled) - 1)
    if df < 1:
        return NotComputed(
            "there are as many distances as pairs, so every set of answers fits perfectly"
        )
    own = pooled / np.where(trials > 0, trials, 1)
    found = float(2 * (xlogy(pooled, own) - xlogy(pooled, p)).sum())
    return ScaleTest(deviance=found, df=df, p=float(stats.chi2.sf(found, df)))
