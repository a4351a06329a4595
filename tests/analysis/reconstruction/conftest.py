from __future__ import annotations

from fractions import Fraction
from itertools import combinations_with_replacement
from math import factorial, prod

import pytest

from analysis.reconstruction.published_table import Column, Scale
from analysis.reconstruction.rounding import Printed

NAMES = ("maximum_deviation", "observed_minimum", "observed_maximum", "median")


def _column(n, mean, sd, *, maximum=100, minimum=0, step=1, **more):
    printed = {name: Printed(more.pop(name)) for name in NAMES if name in more}
    scale = Scale(minimum=Fraction(minimum), maximum=Fraction(maximum), step=Fraction(step))
    return Column(
        label="x", n=n, mean=Printed(mean), sd=Printed(sd), scale=scale, **printed, **more
    )


def _multisets(column):
    """Every multiset of ratings that a column allows, by trying them all, in fractions."""
    scale, rule = column.scale, column.rounding
    degrees = column.n - 1 if column.sd_convention == "sample" else column.n
    sd = column.sd.values(rule)
    found = []
    for steps in combinations_with_replacement(range(scale.steps + 1), column.n):
        x = [scale.value(v) for v in steps]
        mean = sum(x) / column.n
        variance = sum((v - mean) ** 2 for v in x) / degrees
        # sd is printed so if some number with this square lies in its interval.
        high = variance < sd.high**2 or (sd.high_closed and variance == sd.high**2)
        low = sd.low < 0 or variance > sd.low**2 or (sd.low_closed and variance == sd.low**2)
        h = column.n // 2
        facts = {
            "mean": mean,
            "maximum_deviation": max(abs(v - mean) for v in x),
            "observed_minimum": x[0],
            "observed_maximum": x[-1],
            "median": x[h] if column.n % 2 else (x[h - 1] + x[h]) / 2,
        }
        printed = {name: getattr(column, name) for name in facts}
        if (
            high
            and low
            and all(p is None or facts[k] in p.values(rule) for k, p in printed.items())
        ):
            found.append(steps)
    return found


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
