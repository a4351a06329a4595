"""Run the tests: at once, or folder after folder where one worker has to do with little memory.

A process keeps what it imported. One that runs every test holds 1.3 GB at its end; one per folder
holds half of that.

    python -m tests.support.parts -n WORKERS [pytest's own arguments]
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree as ET

from tests.support.workers import memory_bytes, workers

COMMAND = [sys.executable, "-m", "pytest"]
NO_TESTS = 5  # pytest's status when nothing was selected, as with -k


def parts(root: Path) -> list[list[str]]:
    """Return what each process runs: a folder of tests, the files in none, examples at last."""
    folders = sorted(root.glob("tests/*/"))
    tests = [[str(f.relative_to(root))] for f in folders if any(f.rglob("test_*.py"))]
    files = [str(file.relative_to(root)) for file in sorted(root.glob("tests/test_*.py"))]
    return [*tests, files, ["src/slipscale", "tools/site"]]


def counts(report: Path) -> Counter[str]:
    """Return the numbers of tests by result in pytest's JUnit file; an absent file is an error."""
    if not report.is_file():
        return Counter(error=1)
    suite = next(ET.parse(report).iter("testsuite"))  # noqa: S314 -- written by pytest just now
    number = {key: int(suite.get(key, 0)) for key in ("tests", "failures", "errors", "skipped")}
    passed = number["tests"] - number["failures"] - number["errors"] - number["skipped"]
    return Counter(
        failed=number["failures"],
        passed=passed,
        skipped=number["skipped"],
        error=number["errors"],
    )


def run_in_parts(root: Path, arguments: list[str]) -> int:
    """Run each part in a process of its own and print the sum as pytest prints its last line."""
    began, status, total = time.monotonic(), 0, Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for index, part in enumerate(filter(None, parts(root))):
            report = Path(folder, f"{index}.xml")
            options = ["-n", "0", f"--junitxml={report}", *arguments, *part]
            ended = subprocess.run([*COMMAND, *options], cwd=root, check=False).returncode
            total += counts(report)
            status = status or (0 if ended == NO_TESTS else ended)
    numbers = ", ".join(f"{number} {result}" for result, number in total.items() if number)
    print(f"All parts: {numbers or 'no tests'} in {time.monotonic() - began:.2f}s")
    return status


def main(arguments: list[str]) -> int:
    """Run all tests with ``-n WORKERS``; ``logical`` takes what processors and memory allow."""
    _, wanted, *others = arguments
    number = workers(os.cpu_count() or 1, memory_bytes()) if wanted == "logical" else int(wanted)
    chosen = any(Path(argument.partition("::")[0]).exists() for argument in others)
    if number > 1 or chosen:
        distribution = ["-n", str(number), "--dist", "worksteal"]
        return subprocess.run([*COMMAND, *distribution, *others], check=False).returncode
    return run_in_parts(Path.cwd(), others)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
