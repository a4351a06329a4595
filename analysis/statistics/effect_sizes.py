"""Effect sizes with intervals that hold what they promise for a dozen participants."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.statistics.confidence_interval import ConfidenceInterval

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: Sums of squares below this, relative, are rounding.
TINY = 1e-12
#: Differences without noise: SciPy's search would take minutes for an interval of no use.
LARGEST_T = 1e4
#: Below this SciPy's direct inverse can give the answer for t = 0; a root is searched instead.
SMALL_T = 1.0


def _noncentrality(t: float, df: int, p: float) -> float:
    """Return the non-centrality at which a small t has the cumulative probability p."""
    from scipy import optimize, stats  # noqa: PLC0415 - see `d_z_interval`

    return float(optimize.brentq(lambda shift: stats.nct.cdf(t, df, shift) - p, -8.0, 8.0))


def d_z_interval(t: float, n: int, confidence: float) -> ConfidenceInterval | None:
    """Return the interval of d_z, the mean of n differences over their standard deviation.

    None where t is beyond `LARGEST_T`, or SciPy cannot find it.

    Exact for normal differences: t is non-central with d_z √n, so the interval leaves out 0
    exactly where the paired t test is significant (Cumming and Finch 2001, Educ. Psychol. Meas.
    61, 532-574; also what JASP prints). pingouin's approximation does not: at n = 4 it covers
    0 with p = .02.

    >>> [round(bound, 2) for bound in d_z_interval(4.66, 4, 0.95) or ()]
    [0.3, 4.33]
    """
    from scipy import special  # noqa: PLC0415 - a second's import, only when an interval is asked for

    if abs(t) > LARGEST_T:
        return None
    tail = (1 - confidence) / 2
    if abs(t) < SMALL_T:
        bounds = [_noncentrality(t, n - 1, p) for p in (1 - tail, tail)]
    else:
        bounds = [float(special.nctdtrinc(n - 1, p, t)) for p in (1 - tail, tail)]
    # SciPy's search ends at its own bounds where t is too large.
    found = all(
        abs(t) < SMALL_T or np.isclose(special.nctdtr(n - 1, bound, t), p, atol=1e-3)
        for bound, p in zip(bounds, (1 - tail, tail), strict=True)
    )
    low, high = (bound / n**0.5 for bound in bounds)
    return ConfidenceInterval(low, high, confidence) if found else None


def generalised_eta_squared(values: Array) -> float:
    """Return generalised eta squared: the amplitudes' sum of squares over the total one.

    Olejnik and Algina (2003), Psychol. Methods 8, 434-447; with one within-participant factor,
    effect, people and error make the total.

    Parameters
    ----------
    values : array, shape (participants, amplitudes)
        Complete.
    """
    effect, total = _sums(values - values.mean())
    return float(effect[0] / total[0]) if total[0] > 0 else float("nan")


def _sums(centred: Array, leave_out: bool = False) -> tuple[Array, Array]:
    """Return the effect's and the total sum of squares; without each participant in turn."""
    n, k = centred.shape
    left = centred if leave_out else np.zeros((1, k))
    n = n - 1 if leave_out else n
    means = (centred.sum(axis=0) - left) / n
    grand = means.mean(axis=1)
    squares = (centred**2).sum() - (left**2).sum(axis=1)
    effect = n * ((means - grand[:, None]) ** 2).sum(axis=1)
    return effect, squares - n * k * grand**2


def eta_squared_interval(values: Array, confidence: float) -> ConfidenceInterval | None:
    """Return the interval of generalised eta squared; None where it is not defined.

    Tukey's jackknife over participants on Fisher's z of the correlation ratio, artanh η, with
    Student's t: it covers as stated from six participants on (tests/analysis), where the
    percentile bootstrap of a dozen covers some 75 % instead of 95, η² being biased upwards.

    Parameters
    ----------
    values : array, shape (participants, amplitudes)
        Complete, at least three participants.
    """
    from scipy import stats  # noqa: PLC0415

    n = len(values)
    centred = values - values.mean()
    (effect, total), (effects, totals) = _sums(centred), _sums(centred, leave_out=True)
    if min(totals.min(), (totals - effects).min()) <= TINY * total[0]:
        return None
    whole, each = np.arctanh(np.sqrt(effect / total)), np.arctanh(np.sqrt(effects / totals))
    pseudo = n * whole - (n - 1) * each
    half = stats.t.ppf((1 + confidence) / 2, n - 1) * pseudo.std(ddof=1) / n**0.5
    low, high = (float(np.tanh(max(pseudo.mean() + sign * half, 0.0)) ** 2) for sign in (-1, 1))
    return ConfidenceInterval(low, high, confidence)
