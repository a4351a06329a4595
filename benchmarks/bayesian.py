"""Compare the intervals of the group exponent in studies with a known exponent.

    OMP_NUM_THREADS=1 .venv/bin/python -m benchmarks.bayesian [--studies 30] [--write]

Each participant's exponent and scale are drawn from normal distributions, and log estimates have
normal noise. The extra ``bayes`` is required. The table shows the coverage of 95 % intervals, their
mean width, and the bias of the estimate. Sampling takes about 5 s of processor time per study.
"""

from __future__ import annotations

import argparse
import datetime as dt

import numpy as np
import pandas as pd

from benchmarks.measured_page import put
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.tasks.estimation.statistics import (
    BAYESIAN_GROWTH,
    MIXED_MODEL,
    POWER_LAW,
)

LEVELS = (0.5, 1.2, 2.3)
EXPONENT, SD_EXPONENT, SD_SCALE, NOISE = 0.5, 0.15, 0.4, 0.2
TRIALS = 2
SEED = 45
SIZES = (6, 12)
NAMES = (
    "hierarchical Bayesian model",
    "mixed model, t interval",
    "mean of participants' slopes, t interval",
)


def study(people: int, rng: np.random.Generator) -> pd.DataFrame:
    """Return the estimates of a simulated study."""
    rows = [
        (f"p{who:02d}", level, np.exp(3 + scale + slope * np.log(level) + NOISE * rng.normal()))
        for who in range(people)
        for scale in [SD_SCALE * rng.normal()]
        for slope in [EXPONENT + SD_EXPONENT * rng.normal()]
        for level in LEVELS
        for _ in range(TRIALS)
    ]
    return pd.DataFrame(rows, columns=["participant_id", "amplitude_um_pp", "estimate"])


def rows(studies: int) -> list[str]:
    """Return the table's rows."""
    found: dict[tuple[int, int], list[tuple[float, float, float]]] = {}
    for people in SIZES:
        rng = np.random.default_rng([SEED, people])
        for _ in range(studies):
            inference = analyse(study(people, rng), normalise="none", bayesian=True).inference
            kinds = (inference[BAYESIAN_GROWTH], inference[MIXED_MODEL], inference[POWER_LAW])
            for place, each in enumerate(kinds):
                if each:
                    low, high = each.interval
                    found.setdefault((place, people), []).append((each.exponent, low, high))
    lines = [f"| interval | {' | '.join(f'{n} people' for n in SIZES)} |"]
    lines.append("| --- |" + " --- |" * len(SIZES))
    for place, name in enumerate(NAMES):
        cells = []
        for people in SIZES:
            value, low, high = np.array(found[place, people]).T
            covered = float(((low <= EXPONENT) & (high >= EXPONENT)).mean())
            width, bias = float((high - low).mean()), float(value.mean()) - EXPONENT
            cells.append(f"{covered:.3f}; {width:.2f}; {bias:+.3f}")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--studies", type=int, default=30)
    parser.add_argument("--write", action="store_true", help="put the table into the page")
    asked = parser.parse_args()
    lines = rows(asked.studies)
    print("\n".join(lines))
    if asked.write:
        head = f"{asked.studies} studies per cell, seed {SEED}, {dt.datetime.now(dt.UTC):%Y-%m-%d}."
        put("bayesian", [head, "", *lines])


if __name__ == "__main__":
    main()
