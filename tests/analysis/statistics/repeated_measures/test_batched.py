"""Wilcoxon's test on whole arrays against SciPy's, row by row."""

import numpy as np
import pytest
from scipy import stats

from slipscale.analysis.statistics.repeated_measures.batched import paired_t, signed_rank_p
from slipscale.analysis.statistics.repeated_measures.pairwise import EXACT_AT_MOST


def kinds(n):
    """Return differences without ties, with ties, with ties and zeros, and all of one sign."""
    rng = np.random.default_rng(n)
    whole = rng.integers(1, max(n // 2, 2) + 1, size=(6, n)) * rng.choice([-1.0, 1.0], size=(6, n))
    zeros = np.where(rng.random((6, n)) < 0.3, 0.0, whole)
    return np.vstack([rng.normal(0.3, 1, size=(6, n)), whole, zeros, np.abs(whole[:1])])


def scipy_p(steps):
    """Return SciPy's p of differences that are there, by the report's choice of method."""
    steps = steps[np.isfinite(steps) & (steps != 0)]
    if not len(steps):
        return 1.0
    method = "exact" if len(steps) <= EXACT_AT_MOST else "asymptotic"
    return stats.wilcoxon(steps, method=method).pvalue


@pytest.mark.parametrize("n", [*range(1, 53), 80])
def test_signed_ranks_are_scipy_s_for_every_number_of_people_with_ties_and_zeros(n):
    differences = kinds(n)
    expected = [scipy_p(row) for row in differences]
    assert signed_rank_p(differences) == pytest.approx(expected, rel=1e-12)


def test_who_is_missing_counts_for_nothing():
    differences = kinds(12)
    differences[:, [0, 5]] = np.nan
    expected = [scipy_p(row) for row in differences]
    assert signed_rank_p(differences) == pytest.approx(expected, rel=1e-12)


def test_no_change_at_all_is_no_evidence():
    assert signed_rank_p(np.zeros((1, 8))) == pytest.approx([1.0])


def test_paired_t_divides_by_the_sample_standard_deviation():
    # Differences 1, 2 and 6: mean 3, SD √7, so t is 3 √(3 / 7).
    table = np.array([[[1.0, 2.0], [1.0, 3.0], [1.0, 7.0]]])
    assert paired_t(table) == pytest.approx([3 * (3 / 7) ** 0.5])
