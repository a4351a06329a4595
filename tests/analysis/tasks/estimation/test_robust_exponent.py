"""The robust exponent: as R computes it, and hardly moved by lapses and an outlying person."""

import numpy as np
import pytest
from scipy import stats

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import normalised
from slipscale.analysis.tasks.estimation.robust_exponent import median_slope, robust_exponent

EXPONENTS = (0.31, 0.42, 0.55, 0.58, 0.60, 0.63, 0.71, 0.80, 0.95, 1.40)


def prepared(table_by_hand, *, lapse=1.0, last=EXPONENTS[-1]):
    rows = [
        f"p{who},{a},{10 * a**exponent * (lapse if (who + rep == 5 and a == 4) else 1)!r}\n"
        for who, exponent in enumerate((*EXPONENTS[:-1], last))
        for rep in range(4)
        for a in (0.5, 1, 2, 4)
    ]
    data = load(table_by_hand("participant_id,amplitude_um_pp,estimate\n" + "".join(rows)))
    return normalised(data, "none")[1]


def test_the_trimmed_mean_and_its_interval_are_those_of_r(table_by_hand):
    """R 4.2.2: mean(x, trim = 0.2), and Tukey and McLaughlin's interval from winsorised values.

    x <- c(.31, .42, .55, .58, .60, .63, .71, .80, .95, 1.40); w <- pmin(pmax(x, .55), .80);
    mean(x, trim = .2) + qt(.975, 5) * sqrt(9 * var(w) / 30) * c(-1, 1).
    """
    found = robust_exponent(prepared(table_by_hand))
    assert found.exponent == pytest.approx(np.mean(EXPONENTS[2:8]), rel=1e-9)
    winsorised = np.clip(EXPONENTS, 0.55, 0.80)
    half = 2.570581836 * np.sqrt(9 * winsorised.var(ddof=1) / 30)
    assert tuple(found.interval) == pytest.approx((found.exponent - half, found.exponent + half))
    assert (found.n, found.trimmed) == (10, 4)


def test_lapses_and_an_outlying_person_hardly_move_it(table_by_hand):
    usual = robust_exponent(prepared(table_by_hand)).exponent
    changed = robust_exponent(prepared(table_by_hand, lapse=0.01, last=9.0)).exponent
    # A mean of least-squares slopes moves by more than 0.6.
    assert changed == pytest.approx(usual, abs=0.03)


def test_the_median_slope_is_scipys():
    random = np.random.default_rng(5)
    x, y = random.integers(1, 6, 41).astype(float), random.normal(size=41)
    assert median_slope(x, y) == pytest.approx(stats.theilslopes(y, x).slope, rel=1e-12)
