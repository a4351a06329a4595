"""Run all tests: make test.

Tests marked `clock` wait in real time for a board, a window or a browser. Tests of boards run one
after another in one process, and tests that need a display in another. Display tests have a lower
priority, and all other tests the lowest. Boards thus answer in time on two busy cores, and no core
is idle while a test waits. A board switches off if a busy computer is late. Failed tests of boards
and displays are therefore repeated at the end, when nothing else runs; only the repetition counts.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path

ROOT = Path(__file__).parents[1]
MARK, DISPLAY = "pytest.mark.clock", "display"  # strings in the files of such tests
WORKERS = ["-n", "2", "--dist", "worksteal"]
FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)
NOTHING_CHOSEN = 5  # pytest's exit status if no test was selected


def total(summaries: list[str]) -> str:
    """Add up the counts in the summary lines of several pytest runs.

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


def failed(output: str) -> list[str]:
    r"""Return the tests that pytest's summary lists as failed.

    >>> failed("FAILED tests/a.py::test_b[2 x] - assert 1 == 2\nERROR tests/a.py::test_c\n")
    ['tests/a.py::test_b[2 x]', 'tests/a.py::test_c']
    """
    return FAILED.findall(output)


def nice(steps: int) -> list[str]:
    """Return the command prefix for a lower priority; empty if the system has no `nice`."""
    return ["nice", "-n", str(steps)] if shutil.which("nice") else []


def main(options: list[str]) -> int:
    """Run the tests that pytest's options select; return the exit status."""
    pytest = [sys.executable, "-m", "pytest", *options]
    if any((ROOT / word.partition("::")[0]).exists() for word in options):  # folders, files, tests
        return subprocess.call([*pytest, *WORKERS], cwd=ROOT)
    apart = [each for each in (ROOT / "tests").rglob("test_*.py") if MARK in each.read_text()]
    displays = [each for each in apart if DISPLAY in each.read_text()]
    boards = [each for each in apart if each not in displays]
    clock = [*pytest, "-m", "clock", "-p", "no:cacheprovider"]
    with ExitStack() as running:
        waiting = []
        for priority, tests in (([], boards), (nice(10), displays)):
            words = running.enter_context(tempfile.TemporaryFile("w+"))
            command = [*priority, *clock, *map(str, tests)]
            process = running.enter_context(subprocess.Popen(command, cwd=ROOT, stdout=words))
            waiting.append((process, words))
        computing = [*nice(19), *pytest, "-m", "not clock", *WORKERS]
        with subprocess.Popen(computing, cwd=ROOT, stdout=subprocess.PIPE, text=True) as others:
            summaries = [shown(others.stdout or ())]
        statuses, again = {others.wait()}, []
        print("Tests that wait in real time:")
        for process, words in waiting:
            status = process.wait()
            words.seek(0)
            output = words.read()
            summary = shown(output.splitlines(keepends=True))
            if late := failed(output):
                again += late
                summary = re.sub(r"\d+ (failed|errors?),? ?", "", summary)
            else:
                statuses.add(status)
            summaries.append(summary)
    if again:
        print(f"Tests that failed while others ran, repeated alone: {len(again)}", flush=True)
        with subprocess.Popen(
            [*clock, *again], cwd=ROOT, stdout=subprocess.PIPE, text=True
        ) as alone:
            summaries.append(shown(alone.stdout or ()))
        statuses.add(alone.wait())
    print(f"Together: {total(summaries)}")
    return max(statuses - {NOTHING_CHOSEN}, default=NOTHING_CHOSEN)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
