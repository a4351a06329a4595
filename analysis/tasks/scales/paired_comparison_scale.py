"""Paired comparisons: surfaces on one scale, from which of two was chosen.

Bradley and Terry 1952 (Biometrika 39, 324-345): the log odds of a choice are the difference of two
scale values. Thurstone 1927 (Psychol. Rev. 34, 273-286), case V: its probit is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
import numpy.typing as npt

from slipscale.analysis.statistics.confidence_interval import ConfidenceInterval
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.protocols.adaptive.curves import CURVES
from slipscale.faults import UserError

if TYPE_CHECKING:
    from slipscale.experiments.protocols.adaptive.curves import Curve

Array = npt.NDArray[np.float64]

#: With as many participants, their answers need not be independent of each other's.
FEWEST_CLUSTERS = 3
#: How far from certain a fitted choice is kept: beyond, its variance is rounding.
EDGE = 1e-12


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleTest:
    """Whether one scale describes all pairs: deviance from the proportions of each pair."""

    deviance: float
    df: int
    p: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonScale:
    """Surfaces on one scale.

    Parameters
    ----------
    model : {"Bradley-Terry", "Thurstone V"}
        The unit is the natural logarithm of odds, or the standard deviation of a difference.
    values : tuple of float
        One a surface; their sum is 0.
    intervals : tuple of ConfidenceInterval
        One a surface: of its distance from the mean of all.
    covariance : tuple of tuple of float
        Of the values, for distances between any two.
    fit : ScaleTest or NotComputed
        Answers taken as independent.
    answers, participants : int
        How many.
    """

    model: Literal["Bradley-Terry", "Thurstone V"]
    values: tuple[float, ...]
    intervals: tuple[ConfidenceInterval, ...]
    covariance: tuple[tuple[float, ...], ...]
    fit: ScaleTest | NotComputed
    answers: int
    participants: int


def checked_choices(chosen: npt.ArrayLike) -> Array:
    """Return counts as (participants, surfaces, surfaces), or raise `UserError`.

    Parameters
    ----------
    chosen : array_like, shape (surfaces, surfaces) or (participants, surfaces, surfaces)
        How often the row's surface was chosen over the column's.
    """
    counts = np.asarray(chosen, float)
    counts = counts[None] if counts.ndim == 2 else counts  # noqa: PLR2004 - one table of pairs
    if counts.ndim != 3 or counts.shape[1] != counts.shape[2] or counts.shape[1] < 2:  # noqa: PLR2004
        raise UserError("choices: expected a square table of at least two surfaces")
    if not np.isfinite(counts).all() or np.any(counts < 0) or np.any(counts != np.round(counts)):
        raise UserError("choices: expected whole numbers from 0")
    if np.any(np.diagonal(counts, axis1=1, axis2=2)):
        raise UserError("choices: a surface was compared with itself")
    return counts


def bradley_terry(chosen: npt.ArrayLike, confidence: float = 0.95) -> ComparisonScale | NotComputed:
    """Return the Bradley-Terry scale, by maximum likelihood (choix).

    Parameters
    ----------
    chosen : array_like
        `checked_choices`. Given by participant, of whom there are three or more, intervals allow
        for answers of one participant being alike (sandwich estimator, Student's t).
    """
    counts = checked_choices(chosen)
    if why := _unbounded(counts.sum(axis=0)):
        return NotComputed(why)
    from choix import ilsr_pairwise_dense  # noqa: PLC0415 - loads scipy

    try:
        values = ilsr_pairwise_dense(counts.sum(axis=0), tol=1e-10, max_iter=1000)
    except RuntimeError as error:
        return NotComputed(f"the scale could not be fitted ({error})")
    return _scale("Bradley-Terry", CURVES["logistic"], values, counts, confidence)


def thurstone(chosen: npt.ArrayLike, confidence: float = 0.95) -> ComparisonScale | NotComputed:
    """Return Thurstone's scale, case V, by a probit model (statsmodels); see `bradley_terry`."""
    counts = checked_choices(chosen)
    pooled = counts.sum(axis=0)
    if why := _unbounded(pooled):
        return NotComputed(why)
    import statsmodels.api as sm  # noqa: PLC0415 - a second's import

    # A row for each choice made, either way round, weighted by how often.
    one, other = np.nonzero(pooled)
    rows = np.arange(len(one))
    design = np.zeros((len(one), len(pooled)))
    design[rows, one], design[rows, other] = 1.0, -1.0
    found = sm.GLM(
        np.ones(len(one)),
        design[:, 1:],
        freq_weights=pooled[one, other],
        family=sm.families.Binomial(sm.families.links.Probit()),
    ).fit(tol=1e-12)
    if not found.converged:
        return NotComputed("the scale could not be fitted: no convergence")
    values = np.append(0.0, np.asarray(found.params, float))
    return _scale("Thurstone V", CURVES["normal"], values - values.mean(), counts, confidence)


def _unbounded(pooled: Array) -> str | None:
    """Say why the likeliest scale is infinite, or None (Ford 1957, Am. Math. Mon. 64, 28-33)."""
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    groups, _ = connected_components(pooled > 0, directed=True, connection="strong")
    if groups == 1:
        return None
    apart, _ = connected_components(pooled > 0, directed=False)
    if apart > 1:
        return "some surfaces were never compared, directly or by way of others, with the rest"
    return (
        "some surfaces were never chosen over any of the others: their distance has no upper limit"
    )


def _scale(
    model: Literal["Bradley-Terry", "Thurstone V"],
    curve: Curve,
    values: Array,
    counts: Array,
    confidence: float,
) -> ComparisonScale:
    from scipy import stats  # noqa: PLC0415 - half a second's import

    difference = values[:, None] - values[None, :]
    p = np.clip(curve.distribution(difference), EDGE, 1 - EDGE)
    density = curve.density(difference)
    trials = counts + counts.transpose(0, 2, 1)
    weight = trials.sum(axis=0) * density**2 / (p * (1 - p))
    # Information about sum-zero values is a graph's Laplacian; its pseudo-inverse their covariance.
    covariance = np.linalg.pinv(np.diag(weight.sum(axis=1)) - weight)
    participants = len(counts)
    quantile = float(stats.norm.ppf((1 + confidence) / 2))
    if participants >= FEWEST_CLUSTERS:
        scores = ((counts - trials * p) * density / (p * (1 - p))).sum(axis=2)
        spread = scores.T @ scores * participants / (participants - 1)
        covariance = covariance @ spread @ covariance
        quantile = float(stats.t.ppf((1 + confidence) / 2, participants - 1))
    half = quantile * np.sqrt(np.diagonal(covariance))
    return ComparisonScale(
        model=model,
        values=tuple(map(float, values)),
        intervals=tuple(
            ConfidenceInterval(float(value - width), float(value + width), confidence)
            for value, width in zip(values, half, strict=True)
        ),
        covariance=tuple(tuple(map(float, row)) for row in covariance),
        fit=_test(counts.sum(axis=0), p),
        answers=int(counts.sum()),
        participants=participants,
    )


def _test(pooled: Array, p: Array) -> ScaleTest | NotComputed:
    from scipy import stats  # noqa: PLC0415
    from scipy.special import xlogy  # noqa: PLC0415

    trials = pooled + pooled.T
    df = int((np.triu(trials, k=1) > 0).sum()) - (len(pooled) - 1)
    if df < 1:
        return NotComputed("as many distances as pairs: any answers fit")
    own = pooled / np.where(trials > 0, trials, 1)
    found = float(2 * (xlogy(pooled, own) - xlogy(pooled, p)).sum())
    return ScaleTest(deviance=found, df=df, p=float(stats.chi2.sf(found, df)))
