"""How many participants: simulated studies of the shipped population, analysed as the report does.

The population (`experiments.participants.population`) is the pilot's: its means and spreads are
Table III's, the rest is assumed and can be varied. Studies are simulated by the thousand, whole
arrays at a time, without plate and session.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import TYPE_CHECKING

import numpy as np

from analysis.statistics.pairwise import EXACT_AT_MOST
from faults import UserError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from experiments.participants.population import Population

#: Sensation is tabulated at this many places of the population, and interpolated.
PLACES = 241
FARTHEST = 6.0
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
        Share of studies in which Friedman's test found a difference.
    steps : dict
        (lower, upper amplitude in µm peak to peak) -> share of studies in which Wilcoxon's test
        told the neighbours apart, Holm-corrected over all pairs.
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
    from experiments.participants.population import sensation  # noqa: PLC0415 - loads SciPy

    grid = np.linspace(-FARTHEST, FARTHEST, PLACES)
    shape = (studies, participants)
    shared = np.sqrt(population.shared) * rng.normal(size=(*shape, 1))
    own = np.sqrt(population.own) * rng.normal(size=(*shape, len(amplitudes)))
    trial = np.sqrt(population.trial_to_trial) * rng.normal(
        size=(*shape, len(amplitudes), repetitions)
    )
    deviates = np.clip((shared + own)[..., None] + trial, -FARTHEST, FARTHEST)
    felt = np.empty_like(deviates)
    for place, amplitude in enumerate(amplitudes):
        curve = np.array([sensation(float(amplitude), float(deviate)) for deviate in grid])
        felt[:, :, place] = np.interp(deviates[:, :, place], grid, curve)
    # People answer in whole hundredths of their scale: ties and zeros are part of the matter.
    return np.asarray(np.round(felt).mean(axis=-1))


def power_of(
    amplitudes: Sequence[float], values: NDArray[np.float64], alpha: float = 0.05
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
    """
    studies, participants, kinds = values.shape
    pairs = list(combinations(range(kinds), 2))
    p = np.column_stack([_wilcoxon(values[..., high] - values[..., low]) for low, high in pairs])
    told_apart = holm(p) < alpha
    column = {pair: place for place, pair in enumerate(pairs)}
    # Friedman's test needs three amplitudes.
    found = friedman(values) < alpha if kinds > 2 else told_apart  # noqa: PLR2004
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


def friedman(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the p of Friedman's test of each study; `scipy.stats.friedmanchisquare` at scale.

    Parameters
    ----------
    values : array, shape (studies, participants, amplitudes)
    """
    from scipy import stats  # noqa: PLC0415

    _, n, k = values.shape
    ranks = stats.rankdata(values, axis=2)
    # A group of t equal values adds t (t² - 1), each of its members t² - 1.
    equal = (values[..., None] == values[..., None, :]).sum(axis=-1)
    tied = 1 - (equal**2 - 1).sum(axis=(1, 2)) / (n * k * (k**2 - 1))
    chi2 = 12 / (n * k * (k + 1)) * (ranks.sum(axis=1) ** 2).sum(axis=1) - 3 * n * (k + 1)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.nan_to_num(stats.chi2.sf(chi2 / tied, k - 1), nan=1.0))


def holm(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Holm's adjusted p, each row a family; statsmodels' `multipletests` at scale."""
    order = np.argsort(p, axis=1)
    steps = np.take_along_axis(p, order, axis=1) * np.arange(p.shape[1], 0, -1)
    adjusted = np.empty_like(p)
    np.put_along_axis(adjusted, order, np.maximum.accumulate(steps, axis=1), axis=1)
    return np.minimum(adjusted, 1.0)


def _wilcoxon(differences: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Wilcoxon's p of each study; 1 where all differences are zero."""
    from scipy import stats  # noqa: PLC0415

    some = np.any(differences != 0, axis=1)
    p = np.ones(len(differences))
    if some.any():
        # Exact up to the size where the report's test is, ties aside.
        method = "exact" if differences.shape[1] <= EXACT_AT_MOST else "asymptotic"
        p[some] = stats.wilcoxon(differences[some], axis=1, method=method).pvalue
    return p


def _exponent_half_width(amplitudes: Sequence[float], values: NDArray[np.float64]) -> float:
    from scipy import stats  # noqa: PLC0415

    above = np.asarray(amplitudes) > 0
    n = values.shape[1]
    if above.sum() < 2:  # noqa: PLR2004
        return float("nan")
    x = np.log(np.asarray(amplitudes)[above])
    # Where somebody answers zero the least answer possible stands in: it is for planning only.
    y = np.log(np.maximum(values[..., above], 0.5))
    weights = (x - x.mean()) / ((x - x.mean()) ** 2).sum()
    spread = (y @ weights).std(axis=1, ddof=1)
    return float(spread.mean() * stats.t.ppf(0.975, n - 1) / np.sqrt(n))


def power_curve(
    amplitudes: Sequence[float],
    sizes: Sequence[int],
    *,
    repetitions: int = 1,
    studies: int = 1000,
    seed: int = 2007,
    alpha: float = 0.05,
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
        curve.append(power_of(ascending, values, alpha))
    return curve


def fewest(curve: Sequence[Power], target: float) -> int | None:
    """Return the smallest size from which on every share reaches the target, or None."""
    enough: int | None = None
    for point in sorted(curve, key=lambda one: one.participants, reverse=True):
        if point.weakest < target:
            return enough
        enough = point.participants
    return enough
