"""How many participants a study needs: simulated studies, tested as the report tests.

The population (`experiments.participants.population`) is the pilot's: its means and spreads are
Table III's, the rest is assumed and can be varied. Studies are simulated by the thousand, whole
arrays at a time, without plate and session.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import TYPE_CHECKING

import numpy as np

from analysis.planning.simulation import Task, simulate_ratings
from analysis.statistics import batched
from analysis.statistics.regression import fit_lines
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from experiments.participants.population import Population
    from experiments.study.analysis_choices import Primary

    Array = NDArray[np.float64]

#: Estimates simulated at a time: 0.4 GB of them, and a few times that while tests are computed.
MOST_ANSWERS = 50_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Power:
    """The power of one size of study.

    Parameters
    ----------
    participants : int
        Per study.
    omnibus : float
        Share of studies in which the primary analysis found a difference: Friedman's test, or
        the repeated-measures ANOVA of logarithms (Greenhouse-Geisser).
    steps : dict
        (lower, upper amplitude in µm peak to peak) -> share of studies in which Wilcoxon's test,
        or the paired t of logarithms, told the neighbours apart, Holm-corrected over all pairs.
    exponent_half_width : float
        Mean half-width of the exponent's 95 % interval.
    studies : int
        How many were simulated.
    """

    participants: int
    omnibus: float
    steps: dict[tuple[float, float], float]
    exponent_half_width: float
    studies: int

    @property
    def weakest(self) -> float:
        """The least of all shares."""
        return min([self.omnibus, *self.steps.values()])


def simulate(
    amplitudes: Sequence[float],
    *,
    participants: int,
    repetitions: int,
    studies: int,
    population: Population,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return participants' mean estimates, 0 to 100 of their scale.

    Parameters
    ----------
    amplitudes : sequence of float
        µm peak to peak.
    rng : Generator
        The only source of chance.

    Returns
    -------
    array, shape (studies, participants, amplitudes)
    """
    task = Task(amplitudes_um_pp=tuple(amplitudes), repetitions=repetitions)
    ratings = simulate_ratings(
        task, participants=participants, studies=studies, population=population, rng=rng
    )
    return ratings.means(len(amplitudes))


def _signed_rank_p(low: Array, high: Array) -> Array:
    return batched.signed_rank_p(high - low)


def _log_pair_p(low: Array, high: Array) -> Array:
    """Return the paired t's p, of everybody above zero at both; 1 where fewer than three are."""
    from scipy import stats  # noqa: PLC0415

    with np.errstate(invalid="ignore", divide="ignore"):
        difference = np.log(high) - np.log(low)
        difference[~np.isfinite(difference)] = np.nan
        n = np.isfinite(difference).sum(axis=1)
        here = np.isfinite(difference)
        mean = np.where(here, difference, 0.0).sum(axis=1) / n
        squares = np.where(here, difference - mean[:, None], 0.0) ** 2
        error = np.sqrt(squares.sum(axis=1) / (n - 1) / n)
        p = 2 * stats.t.sf(np.abs(mean) / error, n - 1)
    return np.where((n >= 3) & np.isfinite(p), p, 1.0)  # noqa: PLR2004


def _log_anova_p(values: Array) -> Array:
    """Return Greenhouse and Geisser's p of complete participants, study by study."""
    from scipy import stats  # noqa: PLC0415

    p = np.ones(len(values))
    whole: NDArray[np.bool_] = np.asarray(np.all(values > 0, axis=2))
    k = values.shape[2]
    for n in np.unique(whole.sum(axis=1)):
        studies = np.flatnonzero(whole.sum(axis=1) == n)
        if n < 3:  # noqa: PLR2004
            continue
        tables = np.log(values[studies][whole[studies]].reshape(len(studies), n, k))
        epsilon = batched.greenhouse_geisser(tables)
        f = batched.repeated_measures_f(tables)
        p[studies] = stats.f.sf(f, (k - 1) * epsilon, (k - 1) * (n - 1) * epsilon)
    return p


#: Primary analysis -> p of a pair (arrays of shape (studies, participants)), p of all amplitudes.
TESTS: dict[Primary, tuple[Callable[[Array, Array], Array], Callable[[Array], Array]]] = {
    "ranks": (_signed_rank_p, batched.friedman_p),
    "logarithms": (_log_pair_p, _log_anova_p),
}


def power_of(
    amplitudes: Sequence[float],
    values: NDArray[np.float64],
    alpha: float = 0.05,
    primary: Primary = "ranks",
) -> Power:
    """Return the power of studies that were simulated.

    Parameters
    ----------
    amplitudes : sequence of float
        Ascending, µm peak to peak.
    values : array, shape (studies, participants, amplitudes)
        As from `simulate`.
    alpha : float
        Level of each test.
    primary : {"ranks", "logarithms"}
        The study's primary analysis.
    """
    studies, participants, kinds = values.shape
    pairs = list(combinations(range(kinds), 2))
    pair_p, omnibus_p = TESTS[primary]
    p: Array = np.column_stack([pair_p(values[..., low], values[..., high]) for low, high in pairs])
    adjusted = batched.holm(p)
    told_apart = np.asarray(adjusted) < alpha
    column = {pair: place for place, pair in enumerate(pairs)}
    # Friedman's test needs three amplitudes; of two, both families are their one pair.
    found = (omnibus_p(values) if kinds > 2 else adjusted) < alpha  # noqa: PLR2004
    omnibus = float(found.mean())
    return Power(
        participants=participants,
        omnibus=omnibus,
        steps={
            (amplitudes[low], amplitudes[high]): float(told_apart[:, column[low, high]].mean())
            for low, high in pairwise(range(kinds))
        },
        exponent_half_width=_exponent_half_width(amplitudes, values),
        studies=studies,
    )


def _exponent_half_width(amplitudes: Sequence[float], values: NDArray[np.float64]) -> float:
    from scipy import stats  # noqa: PLC0415

    above = np.asarray(amplitudes) > 0
    n = values.shape[1]
    if above.sum() < 2:  # noqa: PLR2004
        return float("nan")
    x = np.log(np.asarray(amplitudes)[above])
    # Where somebody answers zero the least answer possible stands in: it is for planning only.
    y = np.log(np.maximum(values[..., above], 0.5))
    spread = fit_lines(x, y).slope.std(axis=1, ddof=1)
    return float(spread.mean() * stats.t.ppf(0.975, n - 1) / np.sqrt(n))


def power_curve(
    amplitudes: Sequence[float],
    sizes: Sequence[int],
    *,
    repetitions: int = 1,
    studies: int = 1000,
    seed: int = 2007,
    alpha: float = 0.05,
    primary: Primary = "ranks",
    population: Population | None = None,
    progress: Callable[[str], None] | None = None,
) -> list[Power]:
    """Return the power of studies of several sizes; the same seed gives the same numbers.

    Raises
    ------
    UserError
        Fewer than two amplitudes, a size under three, or more than a computer can hold.
    """
    from experiments.participants.population import Population  # noqa: PLC0415

    ascending = sorted(float(value) for value in amplitudes)
    if len(ascending) < 2:  # noqa: PLR2004
        raise UserError("two amplitudes or more are needed to tell apart")
    if min(sizes) < 3:  # noqa: PLR2004
        raise UserError(f"{min(sizes)} participants; expected 3 or more")
    answers = studies * max(sizes) * len(ascending) * repetitions
    if answers > MOST_ANSWERS:
        raise UserError(
            f"{studies} studies of {max(sizes)} participants are {answers:.3g} estimates; "
            f"expected at most {MOST_ANSWERS:.0g}, which a computer's memory holds: fewer studies "
            "or smaller ones"
        )
    curve = []
    for size in sizes:
        if progress:
            progress(f"{studies} studies of {size} participants")
        values = simulate(
            ascending,
            participants=size,
            repetitions=repetitions,
            studies=studies,
            population=population or Population(),
            rng=np.random.default_rng([seed, size]),
        )
        curve.append(power_of(ascending, values, alpha, primary))
    return curve


def fewest(curve: Sequence[Power], target: float) -> int | None:
    """Return the smallest size from which on every share reaches the target, or None."""
    enough: int | None = None
    for point in sorted(curve, key=lambda one: one.participants, reverse=True):
        if point.weakest < target:
            return enough
        enough = point.participants
    return enough
