"""How fast a simulated participant is: a full session that waits for the disk, a pilot's, bare.

    python benchmarks/pilot_speed.py [--participants 12] [--rounds 5] [--study biet2007]

The three take turns, so that what else the machine does falls on all alike. A session that waits
for the disk at each record is what a pilot was before, and still is where faults are tried; bare is
protocol and person alone, with the same answers.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.running.pilot import pilot_plans, run_simulated

if TYPE_CHECKING:
    from collections.abc import Callable

    from slipscale.experiments.study.run_plan import RunPlan

# A mock whose sensor has its usual noise, said in words: the journal then waits for the disk.
SYNCED = "mock:"


def session(plan: RunPlan, spec: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        run_simulated(Path(folder), plan, spec)


def bare(plan: RunPlan) -> None:
    for _ in bare_run(plan, Population()):
        pass


WAYS: dict[str, Callable[[RunPlan], None]] = {
    "session, on disk at each record": lambda plan: session(plan, SYNCED),
    "session of a pilot": lambda plan: session(plan, "mock"),
    "bare": bare,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--participants", type=int, default=12)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--study", default="biet2007")
    options = parser.parse_args()
    plans = pilot_plans(options.study, participants=options.participants, seed=None, language=None)
    for run in WAYS.values():
        run(plans[0])  # imports and tables
    wall: dict[str, list[float]] = {name: [] for name in WAYS}
    cpu: dict[str, list[float]] = {name: [] for name in WAYS}
    for _ in range(options.rounds):
        for name, run in WAYS.items():
            began, began_cpu = time.perf_counter(), time.process_time()
            for plan in plans:
                run(plan)
            wall[name].append(1000 * (time.perf_counter() - began) / len(plans))
            cpu[name].append(1000 * (time.process_time() - began_cpu) / len(plans))
    first = median(wall["session, on disk at each record"])
    print(f"{'':34} wall ms   CPU ms   faster (wall)")
    for name in WAYS:
        print(
            f"{name:34} {median(wall[name]):7.2f}  {median(cpu[name]):7.2f}   "
            f"{first / median(wall[name]):7.1f}"
        )
    ratio = median(cpu["session of a pilot"]) / median(cpu["bare"])
    print(f"bare is {ratio:.1f} times as fast (CPU) as a pilot's session")


if __name__ == "__main__":
    main()
