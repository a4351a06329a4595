"""Apply the report's tests to thousands of simulated studies at once.

The tests give the same results as `slipscale.analysis.statistics`, except Wilcoxon's test. Here,
Wilcoxon's test assigns mid-ranks to ties and uses the exact distribution for small samples without
ties, whereas the report uses permutations.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipscale.analysis.planning.simulated.estimates import Ratings, means
from slipscale.analysis.preprocessing.sufficiency import FEWEST
from slipscale.analysis.statistics.arrays import Array
from slipscale.analysis.statistics.holm import holm_rows
from slipscale.analysis.statistics.regression import fit_lines
from slipscale.analysis.statistics.repeated_measures import batched
from slipscale.experiments.study.analysis_choices import Primary, ZeroRule


@dataclass(frozen=True, slots=True, kw_only=True)
class Tables:
    """Participants' normalised means in simulated studies.

    Parameters
    ----------
    levels : tuple of float
    cells, logs : array, shape (studies, participants, amplitudes)
        Mean estimates, and mean natural logarithms of the estimates; NaN if missing.
    usable : bool array, shape (studies,)
        False if `analyse` would reject the study because it cannot be normalised.
    """

    levels: tuple[float, ...]
    cells: Array
    logs: Array
    usable: NDArray[np.bool_]

    def first(self, participants: int) -> Tables:
        """Return the studies reduced to their first `participants` participants."""
        return Tables(
            levels=self.levels,
            cells=self.cells[:, :participants],
            logs=self.logs[:, :participants],
            usable=self.usable,
        )


#: Factor and divisor of each normalisation rule. Each participant's divisor is computed from the
#: estimates (shape: repetitions, studies, participants, amplitudes), their means over repetitions
#: and the scale tops.
DIVISORS: dict[str, tuple[float, Callable[[Array, Array, Array], Array]]] = {
    "none": (1.0, lambda _estimates, _cells, tops: np.ones_like(tops)),
    "scale_top": (100.0, lambda _estimates, _cells, tops: tops),
    "grand_maximum": (
        100.0,
        lambda _estimates, cells, tops: (
            np.zeros_like(tops) + np.nanmax(cells, axis=(1, 2))[:, None]
        ),
    ),
    "participant_maximum": (
        100.0,
        lambda _estimates, cells, _tops: np.nanmax(cells, axis=2),
    ),
    "participant_largest_trial": (
        100.0,
        lambda estimates, _cells, _tops: np.nanmax(estimates, axis=(0, 3)),
    ),
    "top_stimulus": (100.0, lambda _estimates, cells, _tops: cells[:, :, -1]),
    "modulus_equalisation": (1.0, lambda estimates, _cells, _tops: _moduli(estimates)),
}


def _moduli(estimates: Array) -> Array:
    """Return each participant's geometric mean relative to the group's, ignoring zeros."""
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = means(np.where(estimates > 0, np.log(estimates), np.nan))
    own = np.nanmean(logs, axis=2)
    return np.asarray(np.exp(own - np.nanmean(own, axis=1)[:, None]))


def tables(ratings: Ratings, levels: Sequence[float], rule: str, zero_rule: ZeroRule) -> Tables:
    """Normalise simulated studies, and return the means per participant and amplitude.

    Parameters
    ----------
    rule : str
        A key of `DIVISORS`.
    zero_rule : str
        How estimates of zero are treated before taking logarithms.
    """
    k = len(levels)
    percent = ratings.by_amplitude(ratings.percent, k)
    estimates = percent / 100 * ratings.scale_top[..., None]
    with warnings.catch_warnings(), np.errstate(divide="ignore", invalid="ignore"):
        # NaN if a participant dropped out before the first trial or always answered zero.
        warnings.filterwarnings("ignore", "All-NaN|Mean of empty", RuntimeWarning)
        top, divisor = DIVISORS[rule]
        below = divisor(estimates, means(estimates), ratings.scale_top)
        present = ~np.isnan(percent).all(axis=(0, 3))
        usable = np.asarray(((below > 0) | ~present).all(axis=1))
        factor = (top / below)[..., None]
        scaled = percent if rule == "scale_top" else estimates * factor
        zero: NDArray[np.bool_] = np.asarray(scaled == 0)
        if zero_rule == "half_minimum":
            least = np.nanmin(np.where(scaled > 0, scaled, np.nan), axis=(0, 2, 3)) / 2
            scaled_positive = np.where(zero, least[:, None, None], scaled)
        else:
            scaled_positive = np.where(zero, np.nan, scaled)
        final = np.log(scaled_positive)
        if zero_rule == "refuse":
            final = np.where(np.any(zero, axis=(0, 2, 3), keepdims=True), np.nan, final)
        return Tables(
            levels=tuple(levels),
            cells=means(scaled),
            logs=means(final),
            usable=usable,
        )


def _of_complete(values: Array, test: Callable[[Array], Array]) -> Array:
    """Return each study's p-value from participants with complete data; 1 if there are too few."""
    p = np.ones(len(values))
    whole: NDArray[np.bool_] = np.array(np.isfinite(values).all(axis=2), dtype=np.bool_)
    number = whole.sum(axis=1)
    for n in np.unique(number[number >= FEWEST]):
        studies = np.flatnonzero(number == n)
        complete = values[studies][whole[studies]].reshape(len(studies), n, -1)
        found = test(complete)
        p[studies] = np.where(np.isnan(found), 1.0, found)
    return p


def _anova(logs: Array, df: int | None = None) -> Array:
    from scipy.special import fdtrc

    n, k = logs.shape[1:]
    df = df or k - 1
    epsilon = batched.greenhouse_geisser(logs, df)
    f = batched.repeated_measures_f(logs)
    return np.asarray(fdtrc(df * epsilon, df * (n - 1) * epsilon, f))


def factor_p(logs: Array, sizes: Sequence[int]) -> Iterator[Array]:
    """Yield p-values for each factor's main effect and for its interaction with the amplitude.

    As in the report, each factor is tested together with the amplitude, averaging over all other
    factors.

    Parameters
    ----------
    logs : array, shape (studies, participants, conditions x amplitudes)
    sizes : sequence of int
        Number of levels of each factor.
    """
    studies, people = logs.shape[:2]
    cells = logs.reshape(studies, people, *sizes, -1)
    k = cells.shape[-1]
    for place, size in enumerate(sizes):
        of_factor = np.moveaxis(cells, 2 + place, -2).reshape(studies, people, -1, size, k)
        two_way = means(np.moveaxis(of_factor, 2, 0)).reshape(studies, people, -1)
        tests = (partial(_main_effect, k=k), partial(_interaction, k=k))
        yield from (_of_complete(two_way, test) for test in tests)


def _main_effect(logs: Array, k: int) -> Array:
    return _anova(logs.reshape(*logs.shape[:2], -1, k).mean(axis=3))


def _interaction(logs: Array, k: int) -> Array:
    cells = logs.reshape(*logs.shape[:2], -1, k)
    return _anova(batched.interactions(cells), (cells.shape[2] - 1) * (k - 1))


class _Means(NamedTuple):
    """Means across participants, with standard errors and numbers of values."""

    mean: Array
    error: Array
    n: NDArray[np.int64]


def _mean_over_participants(values: Array) -> _Means:
    """Return means over the second axis, ignoring NaN."""
    here = np.isfinite(values)
    n = here.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(here, values, 0.0).sum(axis=1) / n
        squares = np.where(here, values - mean[:, None], 0.0) ** 2
        return _Means(mean, np.sqrt(squares.sum(axis=1) / (n - 1) / n), n)


def _mean_p(values: Array) -> Array:
    """Return the p-value of a t test of each row against 0; 1 for rows with under three values."""
    from scipy.special import stdtr

    mean, error, n = _mean_over_participants(values)
    with np.errstate(invalid="ignore", divide="ignore"):
        p = 2 * stdtr(n - 1, -np.abs(mean) / error)
    return np.where((n >= FEWEST) & np.isfinite(p), p, 1.0)


def _trend(found: Tables) -> Array:
    amplitudes = np.array(found.levels)
    weights = amplitudes - amplitudes.mean()
    return _mean_p(found.logs @ (weights / (weights**2).sum()))


def exponents(found: Tables) -> Array:
    """Return participants' exponents, shape (studies, participants); NaN if undefined."""
    amplitudes = np.array(found.levels)
    above = amplitudes > 0
    if above.sum() < 2:  # noqa: PLR2004
        return np.full(found.cells.shape[:2], np.nan)
    return fit_lines(np.log(amplitudes[above]), found.logs[..., above]).slope


#: Functions that return one p-value per study, keyed by the test's name in study files.
TESTS: dict[str, Callable[[Tables], Array]] = {
    "friedman": lambda found: _of_complete(found.cells, batched.friedman_p),
    "rm_anova": lambda found: _of_complete(found.logs, _anova),
    "linear_trend": _trend,
    "power_law": lambda found: _mean_p(exponents(found)),
}
OMNIBUS: dict[Primary, str] = {"ranks": "friedman", "logarithms": "rm_anova"}


def pairs(levels: Sequence[float]) -> list[tuple[float, float]]:
    """Return all pairs of amplitudes, in the same order as in the report."""
    return list(combinations(levels, 2))


def pairwise(found: Tables, primary: Primary) -> Array:
    """Return Holm-corrected p-values for all pairs, shape (studies, pairs); 1 if undefined."""
    values = found.cells if primary == "ranks" else found.logs
    low, high = np.transpose(list(combinations(range(len(found.levels)), 2)))
    # One row per study and pair.
    differences = np.swapaxes(values[..., high] - values[..., low], 1, 2)
    raw = PAIRED[primary](differences.reshape(-1, values.shape[1])).reshape(len(values), -1)
    return np.where(np.isnan(raw), 1.0, holm_rows(raw))


def _signed_ranks(differences: Array) -> Array:
    """Return signed-rank p-values per row; NaN for too few people or if all differences are 0."""
    p = batched.signed_rank_p(differences)
    enough = np.isfinite(differences).sum(axis=1) >= FEWEST
    changed = (np.nan_to_num(differences) != 0).any(axis=1)
    return np.where(enough & changed, p, np.nan)


def _paired_t(differences: Array) -> Array:
    enough = np.isfinite(differences).sum(axis=1) >= FEWEST
    return np.where(enough, _mean_p(differences), np.nan)


PAIRED: dict[Primary, Callable[[Array], Array]] = {
    "ranks": _signed_ranks,
    "logarithms": _paired_t,
}


def half_widths(values: Array, confidence: float) -> Array:
    """Return half-widths of the t intervals for each study's means across participants.

    Parameters
    ----------
    values : array, shape (studies, participants, ...)

    Returns
    -------
    array, shape (studies, ...)
        NaN for fewer than three participants.
    """
    from scipy.special import stdtrit

    _, error, n = _mean_over_participants(values)
    people = np.arange(values.shape[1] + 1)
    with np.errstate(invalid="ignore"):
        width = error * stdtrit(people - 1, (1 + confidence) / 2)[n]
    return np.where(n >= FEWEST, width, np.nan)
