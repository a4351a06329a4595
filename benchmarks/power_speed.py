"""Power against R's loop of the same model and tests, and how it grows; draws ``power_growth.svg``.

    python benchmarks/power_speed.py [--studies 400] [--out DIR]

R's side is `tests/data/power_reference/power.R`: base R, Friedman's test and Wilcoxon's of six
pairs with Holm's correction, of the magnitude question with 12 participants and one rating. Both
take turns in one run, in processor time; R's start is left out by timing inside R.
"""

from __future__ import annotations

import argparse
import subprocess
import time
from pathlib import Path
from statistics import median

from analysis.planning.design import design_of
from analysis.planning.grid import Condition
from analysis.planning.run_grid import run_grid, shards
from analysis.planning.shard import Shard
from experiments.participants.population import Population
from experiments.study.file import read_study
from figure_style import BLUE, canvas, save, styled

SCRIPT = Path(__file__).parents[1] / "tests" / "data" / "power_reference" / "power.R"
# The model and the tests of the script, without its cases, and one timed loop of them.
LOOP = """
begun <- sum(proc.time()[1:2])
found <- replicate({studies}, {{
  y <- study(12, 1, 1, 0)
  pairs <- combn(4, 2)
  p <- p.adjust(apply(pairs, 2, function(ij) signed_rank(y[, ij[2]] - y[, ij[1]])), "holm")
  c(friedman.test(y)$p.value < 0.05, p < 0.05)
}})
cat((sum(proc.time()[1:2]) - begun) / {studies})
"""


def r_loop_s(studies: int) -> float:
    model = SCRIPT.read_text(encoding="utf-8").partition('cat("participants')[0]
    done = subprocess.run(
        ["Rscript", "-e", model + LOOP.format(studies=studies)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return float(done.stdout)


def ours_s(
    studies: int, participants: int = 12, repetitions: int = 1, jobs: int | None = None
) -> float:
    """Return processor time of one shard; wall time of a grid over so many processes."""
    design = design_of(*read_study("biet2007"), Population(), 0.05)
    condition = Condition(participants=participants, repetitions=repetitions)
    clock = time.perf_counter if jobs else time.process_time
    began = clock()
    if jobs:
        run_grid(shards(design, [condition], studies=studies, seed=1), jobs=jobs)
    else:
        Shard(design=design, condition=condition, number=0, studies=studies, seed=1).compute()
    return clock() - began


GROWTH: dict[str, dict[float, dict[str, int]]] = {
    "studies": {n: {"studies": n} for n in (100, 300, 1000, 3000)},
    "participants": {n: {"studies": 500, "participants": n} for n in (6, 12, 24, 48)},
    "ratings a surface": {n: {"studies": 500, "repetitions": n} for n in (1, 3, 10, 30)},
    "processes": {n: {"studies": 40_000, "jobs": n} for n in (1, 2)},
}


@styled
def growth_figure(rounds: int):  # type: ignore[no-untyped-def] # noqa: ANN201
    figure, axes = canvas(1, len(GROWTH), size=(10.5, 3.0))
    for panel, (name, cases) in zip(axes, GROWTH.items(), strict=True):
        seconds = [median(ours_s(**case) for _ in range(rounds)) for case in cases.values()]
        panel.loglog(list(cases), seconds, "o-", color=BLUE)
        panel.set(xlabel=name, ylabel="seconds" if panel is axes[0] else "")
        print(name, {n: round(s, 3) for n, s in zip(cases, seconds, strict=True)})
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=400)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path("build"))
    options = parser.parse_args()
    ours_s(10)  # imports and tables
    theirs, ours = [], []
    for _ in range(options.rounds):
        theirs.append(r_loop_s(options.studies))
        ours.append(ours_s(10 * options.studies) / (10 * options.studies))
    ratio = median(theirs) / median(ours)
    print(f"R {1e6 * median(theirs):.0f} µs a study, ours {1e6 * median(ours):.0f} µs: {ratio:.0f}")
    options.out.mkdir(parents=True, exist_ok=True)
    save(growth_figure(options.rounds), options.out / "power_growth.svg", (".svg", ".png"))


if __name__ == "__main__":
    main()
