"""Counting and sampling the data sets behind Table III, beside enumeration.

Run with ``python benchmarks/reconstruction.py``. The enumeration is the depth-first search with
bounds that CLOSURE does, written in Python here: its time is the method's, not that of the
compiled program, which is some hundred times quicker. The peers themselves (pysprite,
closure-core and unsum, rsprite2, CORVIDS) are not run.
"""

from __future__ import annotations

import time
from fractions import Fraction
from math import isqrt
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from analysis.reconstruction.rounding import Printed
from analysis.reconstruction.sampling import Sampler
from analysis.reconstruction.solutions import Solutions
from analysis.reconstruction.table import Column, Scale, read

if TYPE_CHECKING:
    from collections.abc import Callable

    from analysis.reconstruction.pieces import Wanted

BUDGET_S = 20.0
T = TypeVar("T")


def timed(work: Callable[[], T]) -> tuple[T, float]:
    start = time.perf_counter()
    result = work()
    return result, time.perf_counter() - start


def enumerate_until(wish: Wanted, deadline: float) -> tuple[int, bool]:
    """Count sorted samples depth first; return (found, finished)."""
    low, high = wish.low, wish.high
    found = 0
    stack = [(wish.moments.n, wish.moments.total, wish.moments.squares, low)]
    while stack:
        if found % 1024 == 0 and time.perf_counter() > deadline:
            return found, False
        k, s, q, first = stack.pop()
        if k == 1:
            found += first <= s <= high and s * s == q
            continue
        for v in range(first, min(high, s // k, isqrt(max(q // k, 0))) + 1):
            rest, left, most = k - 1, s - v, q - v * v
            if left * left <= rest * most and most <= (v + high) * left - rest * v * high:
                stack.append((rest, left, most, v))
    return found, True


def plain(n: int, mean: str, sd: str) -> Column:
    return Column(
        label=f"n = {n}, mean {mean}, SD {sd}, 0-100",
        n=n,
        mean=Printed(mean),
        sd=Printed(sd),
        scale=Scale(maximum=Fraction(100)),
    )


def columns() -> None:
    print("column, count (ms), first sample (ms), samples a second (multisets, ordered)")
    for column in read(Path("biet2007_table3")).columns:
        _, count_s = min(
            (timed(lambda c=column: Solutions(c).multisets) for _ in range(5)), key=lambda r: r[1]
        )
        rates = []
        for measure in ("multisets", "ordered"):
            sampler, build_s = timed(lambda c=column, m=measure: Sampler(Solutions(c), m))
            generator = np.random.default_rng(1)
            _, first_s = timed(lambda s=sampler, g=generator: s.draw(1, g))
            if measure == "multisets":
                first = build_s + first_s
            sampler.draw(2**18, generator)
            _, second = timed(lambda s=sampler, g=generator: s.draw(2**18, g))
            rates.append(2**18 / second)
        print(
            f"{column.label:>8} {1e3 * count_s:8.1f} {1e3 * first:8.1f} "
            f"{rates[0]:12,.0f} {rates[1]:12,.0f}"
        )


def against_enumeration() -> None:
    print("\nagainst depth-first enumeration (rate extrapolated to the exact count if unfinished)")
    for column in (read(Path("biet2007_table3")).columns[1], plain(20, "50.00", "10.00")):
        solutions = Solutions(column)
        count, ours = timed(lambda s=solutions: s.multisets)
        (found, done), theirs = timed(
            lambda s=solutions: enumerate_until(s.targets.wanted[0], time.perf_counter() + BUDGET_S)
        )
        needed = theirs if done else theirs * count / max(found, 1)
        print(
            f"{column.label}: {count:,} in {ours:.3f} s; enumeration {'' if done else 'about '}"
            f"{needed:.3g} s ({found:,} found): {needed / ours:,.0f} times"
        )


def large() -> None:
    print("\nlarge")
    for n, sd in ((30, "10.00"), (50, "10.00"), (100, "5.00"), (100, "7.00")):
        count, seconds = timed(lambda n=n, sd=sd: Solutions(plain(n, "50.00", sd)).multisets)
        print(f"n = {n}, 0-100, mean 50.00, SD {sd}: {count} in {seconds:.2f} s")


if __name__ == "__main__":
    columns()
    against_enumeration()
    large()
    print("\npeers not run: pysprite, closure-core, unsum, rsprite2, CORVIDS")
