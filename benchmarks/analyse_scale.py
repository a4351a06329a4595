"""Compare `analyse` on a million rows with the cost of reading the same files in pandas.

    .venv/bin/python -m benchmarks.analyse_scale [--participants 4000] [--rows 1000000] [--rounds 3]

Two programs are compared on a simulated data set. The first reads every file with
`pandas.read_csv`, in the plain loop that a user would write. The second runs the whole of
`slipscale analyse`: reading with every check, all tests, figures and report. They alternate, each
in a fresh process, so that other load on the machine affects both. The first run of each program is
ignored, because it fills the file system's cache and the cache of compiled modules. The result is
the median ratio of processor times, of `analyse` without its figures to plain reading; it should be
at most 1.2.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import numpy as np

HEADER = (
    "trial\tblock\tphase\tsurface\tamplitude_um_pp\tamplitude_readback_um_pp\testimate\tscale_top\t"
    "modulus\tresponse_time\tonset\tduration\texploration_time\tresponse_time_source\t"
    "rejected_entries\trepeats\tflag\n"
)

READ = """
import pandas as pd
paths = sorted(folder.glob("sub-*/beh/*.tsv"))
frames = [pd.read_csv(path, sep="\\t", na_values=["n/a"]) for path in paths]
table = pd.concat(frames, ignore_index=True)
assert len(table) == rows, len(table)
"""

ANALYSE = """
from slipscale import figure_style
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting import files

def timed(function):
    def run(*words, **named):
        global apart
        began = time.process_time()
        try:
            return function(*words, **named)
        finally:
            apart += time.process_time() - began
    return run

files.draw = timed(files.draw)
figure_style.svg, figure_style.save = timed(figure_style.svg), timed(figure_style.save)
files.write_analysis(analyse(folder), folder.parent / "out")
"""

WRAP = """
import json, os, resource, sys, time
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # as `slipscale analyse` sets it
from pathlib import Path
folder, rows = Path(sys.argv[1]), int(sys.argv[2])
apart = 0.0  # processor time of figures
start, spent = time.perf_counter(), time.process_time()
{body}
wall, spent = time.perf_counter() - start, time.process_time() - spent
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(json.dumps({{"wall_s": wall, "cpu_s": spent, "figures_s": apart, "peak_mb": peak}}))
"""


def environment() -> dict[str, str]:
    """Return the environment variables, except the one that turns off the bytecode cache."""
    return {name: each for name, each in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}


def write_dataset(folder: Path, participants: int, rows: int) -> None:
    """Write a data set of simulated estimates: a power function, individual scales, some noise."""
    rng = np.random.default_rng(2007)
    amplitudes = np.array([0.0, 0.5, 1.2, 2.3])
    each = rows // participants
    for number in range(1, participants + 1):
        beh = folder / f"sub-{number:05d}" / "beh"
        beh.mkdir(parents=True)
        shown = rng.permutation(np.resize(amplitudes, each))
        logs = np.log(40) + rng.normal(0.8, 0.15) * np.log(shown + 0.15) + rng.normal(0, 0.25, each)
        estimates = np.round(np.clip(np.exp(logs + rng.normal(0, 0.1)), 0.1, 100), 1)
        times = np.round(rng.lognormal(0.7, 0.4, each), 4)
        lines = [
            f"{k + 1}\t1\tmain\tS\t{a:g}\t{a:g}\t{e}\t100\tn/a\t{t}\t{5 * k}\t4\t2\tsimulated"
            "\tn/a\tn/a\tn/a"
            for k, (a, e, t) in enumerate(zip(shown, estimates, times, strict=True))
        ]
        stem = beh / f"sub-{number:05d}_task-magnitudeestimation_run-01_beh"
        stem.with_suffix(".tsv").write_text(HEADER + "\n".join(lines) + "\n")
        sidecar = {"Slipscale": {"study": "scale", "seed": number, "mode": "pilot"}}
        stem.with_suffix(".json").write_text(json.dumps(sidecar))


def measure(body: str, folder: Path, rows: int) -> dict[str, float]:
    """Run code in a fresh process; return its times in seconds and its peak memory in MB."""
    done = subprocess.run(
        [sys.executable, "-c", WRAP.format(body=body), str(folder), str(rows)],
        check=True,
        capture_output=True,
        text=True,
        env=environment(),
    )
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--participants", type=int, default=4000)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    rows = args.rows // args.participants * args.participants
    print(f"{rows:,} rows, {args.participants:,} participants")
    ratios = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "data"
        write_dataset(folder, args.participants, rows)
        for body in (READ, ANALYSE):
            measure(body, folder, rows)
        for _ in range(args.rounds):
            read, ours = (measure(body, folder, rows) for body in (READ, ANALYSE))
            ratios.append((ours["cpu_s"] - ours["figures_s"]) / read["cpu_s"])
            for name, values in (("pandas reads", read), ("analyse", ours)):
                print(
                    f"  {name:<14} {values['wall_s']:7.2f} s   CPU {values['cpu_s']:7.2f} s, "
                    f"figures {values['figures_s']:5.2f} s   peak {values['peak_mb']:7.0f} MB"
                )
    each = ", ".join(f"{ratio:.2f}" for ratio in ratios)
    print(f"  analyse less figures, over reading, CPU: {median(ratios):.2f} (rounds: {each})")


if __name__ == "__main__":
    main()
