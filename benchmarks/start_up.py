"""Time ``slipscale --help`` beside a Python that does nothing.

    .venv/bin/python benchmarks/start_up.py [--runs 20]

Both are whole processes, in turn, so that a machine whose speed drifts treats them alike.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time
from pathlib import Path

COMMANDS = {
    "python -c pass": [sys.executable, "-c", "pass"],
    "slipscale --help": [str(Path(sys.executable).with_name("slipscale")), "--help"],
}


def seconds(command: list[str]) -> float:
    """Return how long a command takes."""
    began = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - began


def main() -> None:
    """Print medians and their ratio."""
    parser = argparse.ArgumentParser(description="Time slipscale --help.")
    parser.add_argument("--runs", type=int, default=20)
    runs = parser.parse_args().runs
    times: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for _ in range(runs + 1):
        for name, command in COMMANDS.items():
            times[name].append(seconds(command))
    medians = {name: statistics.median(found[1:]) for name, found in times.items()}
    for name, median in medians.items():
        print(f"{name:<18} {1000 * median:7.1f} ms")
    bare, ours = medians.values()
    print(f"ratio              {ours / bare:7.2f}")


if __name__ == "__main__":
    main()
