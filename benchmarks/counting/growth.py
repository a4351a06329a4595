"""How counting grows with n, the width of the scale and the decimals printed: figure and table.

    OMP_NUM_THREADS=1 python benchmarks/counting/growth.py [--figure growth.svg]

Each curve leaves out columns that are guessed to take more than `--seconds`. Beside the processor's
time, which other work on the machine hardly touches, stand the memory a count holds at most (planes
of one number of values), what the whole table of states would take, and how far the saddle-point
estimate is from the exact count.
"""

from __future__ import annotations

import argparse
import time
from fractions import Fraction
from math import log10
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.analysis.reconstruction.counts.problem import seconds_to_count
from slipscale.analysis.reconstruction.data_sets.saddle_point import log10_multisets
from slipscale.analysis.reconstruction.data_sets.solutions import Solutions
from slipscale.analysis.reconstruction.table.published_table import Column, Scale
from slipscale.analysis.reconstruction.table.rounding import Printed
from slipscale.figure_style import BLUE, canvas, styled, svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Facts = tuple[int, str, str, int]


def wide(places: int) -> Facts:
    return 30, f"{50:.{places}f}", f"{10:.{places}f}", 100


# Title, horizontal axis, and for each place on it n, mean, SD and the scale's top (from 0).
CURVES: list[tuple[str, str, list[tuple[float, Facts]]]] = [
    (
        "0 to 100, SD 10",
        "n",
        [(n, (n, "50.00", "10.00", 100)) for n in (12, 20, 30, 50, 100, 150, 200)],
    ),
    (
        "1 to 7, SD 1.5",
        "n",
        [(n, (n, "3.00", "1.50", 6)) for n in (50, 100, 200, 500, 1000, 2000)],
    ),
    (
        "n = 20, SD a tenth of the scale",
        "Steps of the scale",
        [(top, (20, f"{top / 2:.2f}", f"{top / 10:.1f}", top)) for top in (10, 20, 50, 100, 200)],
    ),
    (
        "0 to 100, n = 30, SD 10",
        "Decimals printed",
        [(places, wide(places)) for places in (0, 1, 2, 3)],
    ),
]


def column(facts: Facts) -> Column:
    n, mean, sd, top = facts
    return Column(n=n, mean=Printed(mean), sd=Printed(sd), scale=Scale(maximum=Fraction(top)))


def measured(facts: Facts, longest_s: float) -> tuple[float, str] | None:
    """Return seconds and the rest of a line; None if it is guessed to take too long."""
    solutions = Solutions(column(facts), memory_gib=64, minutes=10_000)
    if seconds_to_count(solutions.problems) > longest_s:
        return None
    start = time.process_time()
    count = solutions.multisets
    seconds = time.process_time() - start
    held = max(task.count_bytes for task in solutions.problems) / 2**20
    tables = max(task.bytes for task in solutions.problems) / 2**20
    estimate = log10_multisets(solutions.targets)
    # Of a count beyond floating point the logarithm is still right.
    ratio = "" if estimate is None or not count else f"{10 ** (estimate - log10(count)):.3f}"
    power = log10(count) if count else 0.0
    return seconds, f"10^{power:.1f} | {held:,.1f} | {tables:,.1f} | {ratio}"


def main(longest_s: float, figure: Path | None) -> None:
    drawn = []
    for title, axis, places in CURVES:
        print(f"\n{title}\n")
        heads = "processor, s | data sets | memory, MiB | whole table, MiB | estimate/exact"
        print(f"| {axis} | {heads} |")
        print("| ---: | ---: | ---: | ---: | ---: | ---: |")
        points = []
        for place, facts in places:
            found = measured(facts, longest_s)
            if found is None:
                print(f"| {place:g} | not run |")
                continue
            points.append((place, found[0]))
            print(f"| {place:g} | {found[0]:.3g} | {found[1]} |", flush=True)
        drawn.append((title, axis, points))
    if figure is not None:
        figure.write_text(svg(picture(drawn), salt="growth"), encoding="utf-8")
        print(f"\n{figure}")


@styled
def picture(drawn: list[tuple[str, str, list[tuple[float, float]]]]) -> Figure:
    """Return the curves."""
    figure, axes = canvas(2, 2, size=(7.2, 5.2))
    for ax, (title, axis, points) in zip(axes.flat, drawn, strict=True):
        ax.plot(*zip(*points, strict=True), "o-", color=BLUE, markersize=4)
        ax.set(title=title, xlabel=axis, ylabel="Processor time, s", yscale="log")
        if axis != "Decimals printed":
            ax.set_xscale("log")
        places = [place for place, _ in points]
        ax.set_xticks(places, [f"{place:g}" for place in places], minor=False)
        ax.set_xticks([], minor=True)
    return figure


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="growth of counting")
    parser.add_argument("--seconds", type=float, default=60.0, help="guessed, longest (default 60)")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="draw the curves, as SVG")
    arguments = parser.parse_args()
    main(arguments.seconds, arguments.figure)
