"""Run the quick benchmarks, each next to the usual alternative: make benchmarks.

    .venv/bin/python -m benchmarks.quick [--rounds 3] [--all] [--only WORDS] [--write]

Slipscale and the alternative run in turn. The median time of Slipscale is divided by the
alternative's, so smaller ratios are better. Processor times, which include child processes, hardly
depend on other programs; elapsed times also contain waiting. A benchmark is too slow if the ratio
of processor times is more than 20 % larger than the ratio recorded in ``figures.json``, or the
ratio of elapsed times more than twice as large, in two measurements one after the other. Then the
exit status is 1. ``--write`` records the new ratios.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import sys
import time
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks.ways import Pair, guarded, slow

FIGURES = Path(__file__).with_name("figures.json")
#: Largest growth of the recorded ratio, keyed by kind of time.
WORSE = {"processor": 1.2, "elapsed": 2.0}
Times = dict[str, float]


def spent_s(work: Callable[[], object]) -> Times:
    """Return the times of a call in seconds; processor time includes finished child processes."""

    def now() -> Times:
        used = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        processor = sum(each.ru_utime + each.ru_stime for each in used)
        return {"processor": processor, "elapsed": time.perf_counter()}

    began = now()
    work()
    return {kind: end - began[kind] for kind, end in now().items()}


def ratios(pair: Pair, rounds: int) -> Times:
    """Return the ratios of median times, without a first round that fills caches."""
    ours, other = zip(*[map(spent_s, pair) for _ in range(rounds + 1)][1:], strict=True)

    def middle(times: tuple[Times, ...], kind: str) -> float:
        return median(each[kind] for each in times)

    return {kind: round(middle(ours, kind) / middle(other, kind), 4) for kind in WORSE}


def worse(found: Times, recorded: Mapping[str, float]) -> list[str]:
    """Return the kinds of time whose ratio has grown too much."""
    return [kind for kind, most in WORSE.items() if found[kind] > most * recorded.get(kind, 1e9)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--all", action="store_true", help="measure the slow benchmarks as well")
    parser.add_argument("--only", default="", help="words in the names of the benchmarks to run")
    parser.add_argument("--write", action="store_true", help="record the ratios found here")
    options = parser.parse_args()
    record = json.loads(FIGURES.read_text(encoding="utf-8")) if FIGURES.exists() else {}
    recorded: dict[str, Times] = record.get("ratios", {})
    print(f"recorded: {record.get('date', 'never')}, {record.get('machine', '')}")
    print(f"{'ours / other':<56} {'processor':>9} {'recorded':>9} {'elapsed':>9} {'recorded':>9}")
    found: dict[str, Times] = {}
    slower: list[str] = []
    with TemporaryDirectory() as folder:
        pairs = guarded(Path(folder)) | (slow(Path(folder)) if options.all else {})
        for name, pair in pairs.items():
            if options.only not in name:
                continue
            before = recorded.get(name, {})
            found[name] = ratios(pair, options.rounds)
            if worse(found[name], before):
                found[name] = ratios(pair, options.rounds)
            figures = [
                each.get(kind, float("nan")) for kind in WORSE for each in (found[name], before)
            ]
            print(f"{name:<56}" + "".join(f" {figure:9.3f}" for figure in figures), flush=True)
            slower += [f"{name} ({kind} time)" for kind in worse(found[name], before)]
    if options.write:
        python = f"Python {platform.python_version()}"
        machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores, {python}"
        date = f"{datetime.now(UTC):%Y-%m-%d}"
        record = {"date": date, "machine": machine, "ratios": recorded | found}
        FIGURES.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
        return 0
    for name in slower:
        print(f"slower than recorded, twice: {name}")
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
