"""Check the answers for tables from classical data sets, using the commands that users type.

    .venv/bin/python -m benchmarks.real_tables [WORD ...] [--seconds 10]

Prints the processor and elapsed times, the number of columns whose solutions are counted, and the
verdict on each test. The exit status is 1 if a true number is called impossible, or if an answer
takes more than ``--seconds`` of processor time. WORDs select tables by their titles. The tables are
in ``real_tables.toml``.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory

TABLES = Path(__file__).with_suffix(".toml")
HEAD = "[[table]]\n"
STUCK = 20  # Limit of elapsed time, as a multiple of --seconds; other load may slow the answer.


def processor_s() -> float:
    """Return the processor time of all finished child processes."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def judge(path: Path, seconds: float) -> tuple[bool, str]:
    """Return whether the answer for a table is correct and in time, and a line of output."""
    words = [sys.executable, "-m", "slipscale", "reconstruct", str(path), "--json"]
    before_s, begun_s = processor_s(), time.monotonic()
    try:
        done = subprocess.run(
            words, capture_output=True, text=True, check=False, timeout=STUCK * seconds
        )
    except subprocess.TimeoutExpired:
        return False, f"stopped after {STUCK * seconds:g} s"
    took_s, elapsed_s = processor_s() - before_s, time.monotonic() - begun_s
    try:
        answer = json.loads(done.stdout)
    except json.JSONDecodeError:
        return False, done.stderr.strip()
    columns = answer["columns"]
    counted = sum(column["multisets"] is not None for column in columns)
    verdicts = [test["verdict"] for test in answer.get("tests", [])]
    right = all(c["consistent"] is not False for c in columns) and "impossible" not in verdicts
    line = f"{took_s:5.1f} {elapsed_s:8.1f}   {counted} of {len(columns)}   {', '.join(verdicts)}"
    return right and took_s <= seconds, line


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("word", nargs="*")
    parser.add_argument("--seconds", type=float, default=10.0)
    arguments = parser.parse_args()
    failed = 0
    print(f"{'table':<55} {'cpu s':>5} elapsed s  counted  tests")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "table.toml"
        for text in TABLES.read_text(encoding="utf-8").split(HEAD)[1:]:
            title = tomllib.loads(text)["title"]
            if arguments.word and not any(word in title for word in arguments.word):
                continue
            path.write_text(text, encoding="utf-8")
            good, line = judge(path, arguments.seconds)
            failed += not good
            print(f"{title:<55} {line}{'' if good else '   FAILED'}", flush=True)
    print(f"{failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
