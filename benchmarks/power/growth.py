"""How the time of ``power`` grows, by studies, participants, trials, processes; draws the figure.

    python benchmarks/power/growth.py [--out docs/figures] [--seconds 20]

Less than two minutes. The panel of processes is worth something on a quiet machine alone: nothing
else may run. ``--seconds`` is about how long its grid takes one process.
"""

from __future__ import annotations

import os

# One thread a process, or the linear algebra's own threads would be measured.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import time
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from slipscale.analysis.planning.power.design import design_of
from slipscale.analysis.planning.power.grid import Condition
from slipscale.analysis.planning.power.run_grid import run_grid, shards
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.study.file import read_study
from slipscale.figure_style import BLUE, GREY, canvas, save, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DESIGN = design_of(*read_study("biet2007"), Population(), 0.05)
ROUNDS = 3
#: Panel -> its cases: what stands on the axis, and what is computed.
GROWTH: dict[str, dict[int, dict[str, int]]] = {
    "studies": {n: {"studies": n} for n in (250, 1000, 4000, 16_000)},
    "participants": {n: {"studies": 1000, "participants": n} for n in (6, 12, 24, 48, 96)},
    "trials a participant": {
        4 * n: {"studies": 1000, "repetitions": n} for n in (1, 2, 4, 8, 16, 32)
    },
}
PROCESSES = (1, 2, 4)


def wall_s(studies: int, participants: int = 12, repetitions: int = 1, jobs: int = 1) -> float:
    """Return how long a condition's shards take."""
    condition = Condition(participants=participants, repetitions=repetitions)
    wanted = shards(DESIGN, [condition], studies=studies, seed=1)
    began = time.perf_counter()
    run_grid(wanted, jobs=jobs)
    return time.perf_counter() - began


def in_processes(seconds: float) -> dict[int, float]:
    """Return seconds by the number of processes, of a grid that takes one about ``seconds``."""
    for jobs in PROCESSES:
        wall_s(250 * jobs, jobs=jobs)  # imports and tables, in every process
    each = median(wall_s(4000) for _ in range(ROUNDS)) / 4000
    studies = max(round(seconds / each / 250), 8) * 250
    print(f"processes: {studies:,} studies")
    return {jobs: wall_s(studies, jobs=jobs) for jobs in PROCESSES}


def measured(seconds: float) -> dict[str, dict[int, float]]:
    """Return each panel's seconds."""
    wall_s(250)
    found = {
        name: {n: median(wall_s(**case) for _ in range(ROUNDS)) for n, case in cases.items()}
        for name, cases in GROWTH.items()
    }
    return {**found, f"processes ({os.cpu_count()} cores)": in_processes(seconds)}


@styled
def growth_figure(found: dict[str, dict[int, float]]) -> Figure:
    """Return a panel for each, both axes logarithmic, with a line that grows in proportion."""
    figure, panels = canvas(1, len(found), size=(10.5, 3.0))
    for axes, (name, seconds) in zip(panels, found.items(), strict=True):
        sizes, times = list(seconds), list(seconds.values())
        rises = -1 if name.startswith("processes") else 1
        base = 0 if rises < 0 else -1
        proportion = [times[base] * (size / sizes[base]) ** rises for size in sizes]
        axes.loglog(sizes, proportion, ":", color=GREY, label="in proportion")
        axes.loglog(sizes, times, "o-", color=BLUE, label="measured")
        axes.set(xlabel=name[0].upper() + name[1:])
        axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
        axes.minorticks_off()
        axes.grid(visible=True)
    _numbers(panels)
    panels[0].set_ylabel("Seconds")
    panels[0].legend()
    return figure


def _numbers(panels: Any) -> None:
    """Write seconds as plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator  # noqa: PLC0415 - after the style

    for axes in panels:
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/figures"))
    parser.add_argument("--seconds", type=float, default=20.0)
    options = parser.parse_args()
    found = measured(options.seconds)
    for name, seconds in found.items():
        print(name, {n: round(s, 3) for n, s in seconds.items()})
    options.out.mkdir(parents=True, exist_ok=True)
    save(growth_figure(found), options.out / "power-growth.svg")


if __name__ == "__main__":
    main()
