from __future__ import annotations

from fractions import Fraction
from itertools import combinations_with_replacement
from math import factorial, prod

import numpy as np
import pytest
from scipy.stats import t

from slipscale.analysis.published.printed_numbers import Printed
from slipscale.analysis.reconstruction.table.published_table import Column, Scale

NAMES = (
    "mean_percent",
    "sum",
    "se",
    "ci_low",
    "ci_high",
    "maximum_deviation",
    "observed_minimum",
    "observed_maximum",
    "median",
    "lower_quartile",
    "upper_quartile",
)


def _column(n, mean, sd, *, maximum=100, minimum=0, step=1, **more):
    given = {"mean": mean, "sd": sd} | {name: more.pop(name) for name in NAMES if name in more}
    printed = {name: Printed(text) for name, text in given.items() if text is not None}
    scale = Scale(minimum=Fraction(minimum), maximum=Fraction(maximum), step=Fraction(step))
    return Column(label="x", n=n, scale=scale, **printed, **more)


def _root_fits(printed, square, rule):
    """Whether the root of `square` is printed so."""
    if printed is None:
        return True
    root = printed.values(rule)
    high = square < root.high**2 or (root.high_closed and square == root.high**2)
    return high and (
        root.low < 0 or square > root.low**2 or (root.low_closed and square == root.low**2)
    )


def _multisets(column):
    """Every multiset of ratings that a column allows, by trying them all, in fractions."""
    scale, rule = column.scale, column.rounding
    degrees = column.n - 1 if column.sd_convention == "sample" else column.n
    found = []
    for steps in combinations_with_replacement(range(scale.steps + 1), column.n):
        x = [scale.value(v) for v in steps]
        mean = sum(x) / column.n
        if column.mean is not None and mean not in column.mean.values(rule):
            continue  # before the rest, which takes longer
        variance = sum((v - mean) ** 2 for v in x) / degrees
        h = column.n // 2
        facts = {
            "mean": mean,
            "mean_percent": 100 * mean,
            "sum": sum(x),
            "maximum_deviation": max(abs(v - mean) for v in x),
            "observed_minimum": x[0],
            "observed_maximum": x[-1],
            "median": x[h] if column.n % 2 else (x[h - 1] + x[h]) / 2,
        }
        printed = {name: getattr(column, name) for name in facts}
        if (
            _root_fits(column.sd, variance, rule)
            and _root_fits(column.se, variance / column.n, rule)
            and all(p is None or facts[k] in p.values(rule) for k, p in printed.items())
            and all(v in x for v in column.present)
            and not any(v in x for v in column.absent)
            and all(x.count(v) == times for v, times in column.frequencies)
            and all(
                Fraction(100 * x.count(v), column.n) in share.values(rule)
                for v, share in column.percentages
            )
            and _interval_fits(column, mean, variance)
            and _quartiles_fit(column, [float(v) for v in x])
        ):
            found.append(steps)
    return found


def _interval_fits(column, mean, variance):
    if column.ci_low is None:
        return True
    ends = t.interval(column.ci_percent / 100, column.n - 1)
    se = float(variance / column.n) ** 0.5
    return all(
        printed.values(column.rounding).low <= float(mean) + end * se
        and float(mean) + end * se <= printed.values(column.rounding).high
        for printed, end in zip((column.ci_low, column.ci_high), ends, strict=True)
    )


def _quartiles_fit(column, x):
    """Whether NumPy's, SciPy's or a school book's quartiles are printed so."""
    half, longer = x[: len(x) // 2], x[: (len(x) + 1) // 2]
    upper, upper_longer = x[(len(x) + 1) // 2 :], x[len(x) // 2 :]
    pairs = [
        np.quantile(x, [0.25, 0.75]),
        np.quantile(x, [0.25, 0.75], method="weibull"),
        (np.median(half), np.median(upper)),
        (np.median(longer), np.median(upper_longer)),
    ]
    printed = (column.lower_quartile, column.upper_quartile)
    return any(
        all(
            p is None or Fraction(float(q)) in p.values(column.rounding)
            for p, q in zip(printed, pair, strict=True)
        )
        for pair in pairs
    )


def _orders(steps):
    return factorial(len(steps)) // prod(factorial(steps.count(v)) for v in set(steps))


@pytest.fixture(scope="session")
def column():
    return _column


@pytest.fixture(scope="session")
def all_multisets():
    return _multisets


@pytest.fixture(scope="session")
def orders():
    return _orders
