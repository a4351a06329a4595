"""Run all tests: make test.

Tests marked `clock` wait in real time for a board, a window or a browser. They run one after
another in their own process, before the other tests. The other tests have the lowest priority,
so that a board answers in time on two busy cores, and no core is idle while a test waits.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parents[1]
MARK = "pytest.mark.clock"
WORKERS = ["-n", "2", "--dist", "worksteal"]
NOTHING_CHOSEN = 5  # pytest's status, if a choice such as -k leaves no test


def total(summaries: list[str]) -> str:
    """Add up the counts of several of pytest's last lines.

    >>> total(["1 failed, 20 passed, 3 skipped in 5.10s", "7 passed, 1 skipped in 9.00s"])
    '1 failed, 27 passed, 4 skipped in 9.0s'
    """
    counts: Counter[str] = Counter()
    seconds = 0.0
    for line in summaries:
        for number, word in re.findall(r"(\d+) ([a-z]+)", line):
            counts[word] += int(number)
        if took := re.search(r" in ([\d.]+)s", line):
            seconds = max(seconds, float(took[1]))
    return ", ".join(f"{counts[word]} {word}" for word in counts) + f" in {seconds:.1f}s"


def shown(lines: Iterable[str]) -> str:
    """Print lines as they arrive; return the last one."""
    line = ""
    for line in lines:
        print(line, end="", flush=True)
    return line


def main(options: list[str]) -> int:
    """Run the tests that pytest's options select; return the exit status."""
    pytest = [sys.executable, "-m", "pytest", *options]
    if any((ROOT / word.partition("::")[0]).exists() for word in options):  # folders, files, tests
        return subprocess.call([*pytest, *WORKERS], cwd=ROOT)
    apart = [each for each in (ROOT / "tests").rglob("test_*.py") if MARK in each.read_text()]
    last = ["nice", "-n", "19"] if shutil.which("nice") else []
    clock = [*pytest, "-m", "clock", "-p", "no:cacheprovider", *map(str, apart)]
    computing = [*last, *pytest, "-m", "not clock", *WORKERS]
    with (
        tempfile.TemporaryFile("w+") as waited,
        subprocess.Popen(clock, cwd=ROOT, stdout=waited) as waiting,
    ):
        with subprocess.Popen(computing, cwd=ROOT, stdout=subprocess.PIPE, text=True) as others:
            summaries = [shown(others.stdout or ())]
        statuses = {others.wait(), waiting.wait()} - {NOTHING_CHOSEN}
        print("Tests that wait in real time:")
        waited.seek(0)
        summaries.append(shown(waited))
    print(f"Together: {total(summaries)}")
    return max(statuses, default=NOTHING_CHOSEN)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
