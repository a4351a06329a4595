"""Formulas of textbooks, for recomputing printed numbers without a statistics package."""

import math
from collections import defaultdict
from math import comb, sqrt

import numpy as np
import pytest

#: 97.5 % quantiles of Student's t for 1, 2, ... degrees of freedom, from a printed table.
T = (12.7062047, 4.30265273, 3.18244631, 2.77644511, 2.57058184, 2.44691185, 2.36462425)


def mean(values):
    return sum(values) / len(values)


def sd(values):
    centre = mean(values)
    return sqrt(sum((each - centre) ** 2 for each in values) / (len(values) - 1))


def ends(values, low=-math.inf, high=math.inf):
    """Return the t interval, or None if it is not defined."""
    if len(values) < 3 or max(values) - min(values) < 1e-9:
        return None
    half = T[len(values) - 2] * sd(values) / sqrt(len(values))
    return max(mean(values) - half, low), min(mean(values) + half, high)


def line(x, y):
    """Return the intercept and the slope of the least-squares line."""
    slope = sum((a - mean(x)) * (b - mean(y)) for a, b in zip(x, y, strict=True)) / sum(
        (a - mean(x)) ** 2 for a in x
    )
    return mean(y) - slope * mean(x), slope


def own_means(rows, cell, value):
    """Return participants' means: cell -> participant -> mean."""
    found = defaultdict(lambda: defaultdict(list))
    for who, row in rows:
        found[row[cell]][who].append(value(row))
    return {c: {who: mean(v) for who, v in people.items()} for c, people in found.items()}


def check_mean(found, values, low=-math.inf, high=math.inf):
    """Compare a printed mean, its standard deviation and interval with the plain ones."""
    expected = ends(values, low, high)
    if expected is None:
        assert "reason" in found
        return
    assert found["mean"] == pytest.approx(mean(values))
    assert found["sd"] == pytest.approx(sd(values))
    assert found["ci"] == pytest.approx(expected)
    if "t" in found:
        assert found["df"] == len(values) - 1
        assert found["t"] == pytest.approx(mean(values) / (sd(values) / sqrt(len(values))))


def check_interval(found, expected):
    if expected is None:
        assert found is None or "reason" in found
    else:
        assert found == pytest.approx(expected)


def check_anova(found, table):
    """Compare the F of a repeated-measures analysis of variance."""
    n, k = table.shape
    grand, rows, columns = table.mean(), table.mean(axis=1), table.mean(axis=0)
    error = ((table - rows[:, None] - columns + grand) ** 2).sum() / ((n - 1) * (k - 1))
    f = n * ((columns - grand) ** 2).sum() / (k - 1) / error
    assert (found["F"], found["df1"], found["df2"]) == (pytest.approx(f), k - 1, (n - 1) * (k - 1))
    assert found["n"] == n


def check_friedman(found, table):
    """Compare Friedman's statistic, with its correction for ties."""
    n, k = table.shape
    ranks = np.array([[(r < x).sum() + ((r == x).sum() + 1) / 2 for x in r] for r in table])
    between = ((ranks.mean(axis=0) - (k + 1) / 2) ** 2).sum()
    within = ((ranks - (k + 1) / 2) ** 2).sum()
    assert found["chi2"] == pytest.approx(n**2 * (k - 1) * between / within)
    assert found["n"] == n


def tail(n, least, share):
    """Return the probability of at least ``least`` of n."""
    return sum(comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(least, n + 1))
