"""Counting and sampling the data sets behind Table III, beside enumeration and SPRITE.

Run with ``python benchmarks/counting/table3.py``. Single-threaded; wall-clock times, the best of
several runs where they are short.

The enumeration is the depth-first search with bounds that CLOSURE does, without the extremes,
written in Python here: its time is the method's in this language, not that of the compiled
program. A search that does not finish within its budget is reported as found so far; what the
rest would take is labelled an extrapolation.

SPRITE is run as pysprite 1.2.1 where an interpreter has it, best one of its own::

    python -m venv /tmp/peers && /tmp/peers/bin/pip install pysprite
    python benchmarks/counting/table3.py --pysprite /tmp/peers/bin/python

Counting Likert columns beside closure-core's counter is in ``likert.py``, how counting grows in
``growth.py``. Not run: unsum and rsprite2, which are R packages, and CORVIDS, whose
program is in Python 2.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from fractions import Fraction
from math import isqrt
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from slipscale.analysis.reconstruction.data_sets.sampling import Sampler
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.published_table import Column, Scale
from slipscale.analysis.reconstruction.table.rounding import Printed
from slipscale.analysis.reconstruction.table.table_files import read

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.analysis.reconstruction.counts.partition import Wanted

BUDGET_S = 20.0
DRAWN = 2**18
PEER = Path(__file__).parent / "pysprite_draws.py"
PEER_DRAWS = 200
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


def best(work: Callable[[], T], runs: int = 7) -> float:
    return min(timed(work)[1] for _ in range(runs))


def first_sample(column: Column) -> None:
    Sampler(Solutions(column)).draw(1, np.random.default_rng(1))


def columns() -> None:
    print("column, count (ms), first sample, tables included (ms), samples/s (multisets, ordered)")
    for column in read(Path("biet2007_table3")).columns:
        count_s = best(lambda c=column: Solutions(c).multisets)
        first_s = best(lambda c=column: first_sample(c))
        rates = []
        for measure in ("multisets", "ordered"):
            sampler, generator = Sampler(Solutions(column), measure), np.random.default_rng(1)
            # The first block lists the multisets once; a stream goes on at this rate.
            sampler.draw(DRAWN, generator)
            rates.append(DRAWN / best(lambda s=sampler, g=generator: s.draw(DRAWN, g), 3))
        print(
            f"{column.label:>8} {1e3 * count_s:8.1f} {1e3 * first_s:8.1f} "
            f"{rates[0]:12,.0f} {rates[1]:12,.0f}"
        )


def against_enumeration() -> None:
    print(f"\nagainst depth-first enumeration, at most {BUDGET_S:g} s")
    for column in (read(Path("biet2007_table3")).columns[1], plain(20, "50.00", "10.00")):
        solutions = Solutions(column)
        count, ours = timed(lambda s=solutions: s.multisets)
        (found, done), theirs = timed(
            lambda s=solutions: enumerate_until(s.targets.wanted[0], time.perf_counter() + BUDGET_S)
        )
        print(f"{column.label}: {count:,} counted in {ours:.3f} s")
        if done:
            print(f"  enumeration: {found:,} in {theirs:.3g} s, {theirs / ours:.3g} times as long")
        else:
            print(
                f"  enumeration: {found:,} in {theirs:.3g} s, not finished; at least "
                f"{theirs / ours:,.0f} times as long"
            )
            print(f"  extrapolated, at the same rate: {theirs * count / max(found, 1):.1g} s")


def against_sprite(python: str) -> None:
    print(f"\nagainst SPRITE (pysprite), {PEER_DRAWS} draws a column")
    for column in read(Path("biet2007_table3")).columns:
        sums = {m.total for m in Solutions(column).targets.moments}
        wish = Solutions(column).targets.wanted[0]
        task = {
            "n": column.n,
            "mean": float(column.mean.value),
            "sd": float(column.sd.value),
            "low": wish.low,
            "high": wish.high,
            "draws": PEER_DRAWS,
        }
        ran = subprocess.run(
            [python, "-W", "ignore", str(PEER), json.dumps(task)],
            capture_output=True,
            text=True,
            check=False,
        )
        if ran.returncode:
            print(f"  not run: {(ran.stderr.strip().splitlines() or ['no pysprite'])[-1]}")
            return
        peer = json.loads(ran.stdout)
        right = sum(sum(x) in sums for x in peer["found"])
        ours = best(
            lambda c=column: Sampler(Solutions(c)).draw(PEER_DRAWS, np.random.default_rng(1))
        )
        theirs = peer["seconds"]
        print(
            f"{column.label:>8} pysprite {theirs:.2f} s, {right} of {len(peer['found'])} with the "
            f"right sum; ours, uniform, {1e3 * ours:.1f} ms: {theirs / ours:,.0f} times"
        )


def large() -> None:
    print("\nlarge")
    for n, sd in ((30, "10.00"), (50, "10.00"), (100, "5.00"), (100, "7.00")):
        count, seconds = timed(lambda n=n, sd=sd: Solutions(plain(n, "50.00", sd)).multisets)
        print(f"n = {n}, 0-100, mean 50.00, SD {sd}: {count} in {seconds:.2f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="counting and sampling beside the peers")
    parser.add_argument(
        "--pysprite", metavar="PYTHON", default=sys.executable, help="interpreter with pysprite"
    )
    arguments = parser.parse_args()
    columns()
    against_enumeration()
    against_sprite(arguments.pysprite)
    large()
    print("\nnot run: unsum, rsprite2, CORVIDS; closure-core: likert.py")
