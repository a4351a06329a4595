"""Count circular triads and violations of stochastic transitivity.

A participant who chooses A over B, B over C and C over A has no consistent order of the three
(Kendall and Babington Smith 1940, Biometrika 31, 324-345).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import combinations, permutations
from math import comb

import numpy as np
import numpy.typing as npt

from slipscale.analysis.preprocessing.sufficiency import FEWEST, few
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.scales.paired_comparison_scale import checked_choices

#: Largest number of surfaces for which all possible choices are enumerated (32,768 for 6).
ENUMERATED = 6
#: Number of simulated participants who choose at random, and their seed.
SIMULATIONS, SEED = 10_000, 1940


@dataclass(frozen=True, slots=True, kw_only=True)
class Consistency:
    """Consistency of one participant's choices.

    Parameters
    ----------
    circular_triads : float
        Number of circular triads, averaged over all ways to break ties.
    ties : int
        Number of pairs in which both surfaces were chosen equally often.
    triads : int
        Total number of triads.
    zeta : float
        Coefficient of consistence: 1 without circular triads, 0 for the largest possible number.
    p : float
        Probability of this number of circular triads or fewer if all choices were random. If every
        pair was compared an odd number of times, so that random choices cannot be tied, the p-value
        is exact for up to 6 surfaces and uses Kendall's chi-square for more. Otherwise, it is
        estimated from `SIMULATIONS` simulated participants who make the same number of choices at
        random.
    """

    circular_triads: float
    ties: int
    triads: int
    zeta: float
    p: float


def consistency(chosen: npt.ArrayLike) -> Consistency | NotComputed:
    """Count the circular triads in one participant's choices.

    For each pair, the surface that was chosen more often counts as preferred. If pairs are tied,
    the number of circular triads is averaged over all ways to break the ties.

    Parameters
    ----------
    chosen : array_like, shape (surfaces, surfaces)
        Number of times that the row's surface was chosen over the column's surface.
    """
    counts = checked_choices(chosen).sum(axis=0)
    k = len(counts)
    if k < FEWEST:
        return NotComputed(few("surfaces", k))
    one, other = np.triu_indices(k, k=1)
    trials = (counts + counts.T)[one, other]
    if not trials.all():
        return NotComputed("at least one pair was never compared")
    circular = float(_circular_triads((counts - counts.T)[None])[0])
    ties = int((counts == counts.T)[one, other].sum())
    if (trials % 2 == 0).any():  # random choices can be tied, even if these are not
        tossed = np.zeros((SIMULATIONS, k, k))
        first = np.random.default_rng(SEED).binomial(
            trials.astype(int), 0.5, (SIMULATIONS, len(one))
        )
        tossed[:, one, other] = 2 * first - trials
        few_or_fewer = _circular_triads(tossed - tossed.transpose(0, 2, 1)) <= circular
        # The real participant is added to the simulated ones, so that p is never 0.
        p = float((1 + few_or_fewer.sum()) / (1 + SIMULATIONS))
    else:
        p = _p_so_few(k, round(circular))
    most = (k**3 - (k if k % 2 else 4 * k)) // 24
    return Consistency(
        circular_triads=circular, ties=ties, triads=comb(k, 3), zeta=1 - circular / most, p=p
    )


def _circular_triads(more: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return each table's number of circular triads, averaged over all ways to break ties.

    Parameters
    ----------
    more : array, shape (tables, surfaces, surfaces)
        Choices of the row's surface minus choices of the column's surface. Only the sign is used.
    """
    k = more.shape[1]
    wins, ties = (more > 0).sum(axis=2), (more == 0).sum(axis=2) - 1
    # A score is the number of wins plus a binomial number of broken ties. The mean square of a
    # score follows from the mean and the variance.
    score = wins + ties / 2
    return np.asarray(comb(k, 3) - (score**2 + ties / 4 - score).sum(axis=1) / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class StochasticTransitivity:
    """Counts of triads that violate weak, moderate and strong transitivity.

    Suppose that A is chosen over B, and B over C, at least half of the time. Weak transitivity
    requires that A is also chosen over C at least half of the time. Moderate transitivity requires
    that A is chosen over C at least as often as in the less clear of the other two pairs. Strong
    transitivity requires that A is chosen over C at least as often as in the clearer of the other
    two pairs.
    """

    triads: int
    weak_violations: int
    moderate_violations: int
    strong_violations: int


def stochastic_transitivity(chosen: npt.ArrayLike) -> StochasticTransitivity | NotComputed:
    """Count violations of transitivity in all triads whose three pairs were compared.

    A triad violates transitivity if no order of its three surfaces meets the condition. With
    few answers, strong transitivity is often violated by chance; for a test, see
    `ComparisonScale.fit`.
    """
    counts = checked_choices(chosen).sum(axis=0)
    trials = counts + counts.T
    share = counts / np.where(trials > 0, trials, 1)
    triads, violated = 0, [0, 0, 0]
    for three in combinations(range(len(counts)), 3):
        if any(trials[one, other] == 0 for one, other in combinations(three, 2)):
            continue
        triads += 1
        orders = [
            (share[a, b], share[b, c], share[a, c])
            for a, b, c in permutations(three)
            if min(share[a, b], share[b, c]) >= 0.5  # noqa: PLR2004 - half of the answers
        ]
        least = [(0.5, min(x, y), max(x, y), far) for x, y, far in orders]
        for kind in range(3):
            violated[kind] += not any(one[3] >= one[kind] for one in least)
    if not triads:
        return NotComputed("no three surfaces were all compared with each other")
    return StochasticTransitivity(
        triads=triads,
        weak_violations=violated[0],
        moderate_violations=violated[1],
        strong_violations=violated[2],
    )


@cache
def circular_triads_by_chance(surfaces: int) -> tuple[int, ...]:
    """Return how many of all possible sets of choices have 0, 1, 2, ... circular triads."""
    one, other = np.triu_indices(surfaces, k=1)
    ways = np.arange(1 << len(one))
    scores = np.zeros((len(ways), surfaces), dtype=int)
    for pair, (a, b) in enumerate(zip(one, other, strict=True)):
        first = ways >> pair & 1
        scores[:, a] += first
        scores[:, b] += 1 - first
    circular = comb(surfaces, 3) - (scores * (scores - 1) // 2).sum(axis=1)
    return tuple(np.bincount(circular).tolist())


def _p_so_few(surfaces: int, circular: int) -> float:
    if surfaces <= ENUMERATED:
        ways = circular_triads_by_chance(surfaces)
        return sum(ways[: circular + 1]) / sum(ways)
    from scipy import stats

    df = surfaces * (surfaces - 1) * (surfaces - 2) / (surfaces - 4) ** 2
    # Kendall's continuity correction applies to the probability of at least n + 1 triads, whose
    # complement is returned.
    statistic = 8 / (surfaces - 4) * (comb(surfaces, 3) / 4 - circular - 0.5) + df
    return float(stats.chi2.sf(statistic, df))
