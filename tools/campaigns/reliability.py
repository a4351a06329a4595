"""Check every guarantee in docs/validation/index.md by running its command.

Usage: ``make reliability`` (an hour on a quiet machine), ``make reliability ARGS=--list``,
``make reliability ARGS="--line 5 --line 7"``; ``ARGS=--write`` updates the results on the page.

Prints the result for each guarantee, and how many guarantees hold. The exit status is 1 if a
guarantee does not hold.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "validation" / "index.md"
ROW = re.compile(r"\| (?P<promise>[^|]+) \| `(?P<command>[^`|]+)` \|")
# pytest's summary; a run without tests proves nothing.
PASSED = re.compile(r"(?P<count>\d+) passed")
TOLD = 4000  # maximum number of characters of a failed command's output


@dataclass(frozen=True)
class Promise:
    """Guarantee on the page, and the command that demonstrates it."""

    text: str
    command: str


@dataclass(frozen=True)
class Shown:
    """Whether a guarantee holds, and its command's number of passed tests and duration."""

    promise: Promise
    holds: bool
    passed: int | None
    seconds: float


def promises() -> list[Promise]:
    """Return the page's guarantees in order."""
    found = (ROW.fullmatch(line) for line in PAGE.read_text(encoding="utf-8").splitlines())
    return [Promise(row["promise"], row["command"]) for row in found if row]


def shown(promise: Promise) -> Shown:
    """Run the command of a guarantee, and print the command's output if it fails."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    began_s = time.monotonic()
    done = subprocess.run(
        ["sh", "-c", promise.command],
        cwd=ROOT,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    found = PASSED.search(done.stdout)
    passed = int(found["count"]) if found else None
    # pytest also succeeds if all tests were skipped.
    holds = done.returncode == 0 and not ("pytest" in promise.command and not passed)
    if not holds:
        print(done.stdout[-TOLD:], done.stderr[-TOLD:], file=sys.stderr)
    return Shown(promise, holds, passed, time.monotonic() - began_s)


def summary(results: Sequence[Shown]) -> str:
    """Return the number of guarantees that hold, and the text of those that do not."""
    failed = [result.promise.text for result in results if not result.holds]
    minutes = sum(result.seconds for result in results) / 60
    tests = sum(result.passed or 0 for result in results)
    said = (
        f"{len(results) - len(failed)} of {len(results)} guarantees hold: {tests:,} tests and the "
        f"campaigns, {minutes:.0f} min."
    )
    return "\n".join([said, *(f"Does not hold: {text}" for text in failed)])


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument("--line", type=int, action="append", help="guarantee to check, from 1")
    parser.add_argument("--list", action="store_true", help="list guarantees and commands")


def run(args: Namespace) -> tuple[int, str]:
    """Check the guarantees; return 1 if one does not hold."""
    every = list(enumerate(promises(), 1))
    chosen = [(number, each) for number, each in every if not args.line or number in args.line]
    results = []
    for number, promise in chosen:
        head = f"{number:2}  {promise.text}\n      {promise.command}"
        if args.list:
            print(head)
            continue
        result = shown(promise)
        results.append(result)
        word = "holds" if result.holds else "FAILS"
        tests = "" if result.passed is None else f", {result.passed} tests"
        print(f"{head}\n      {word}, {result.seconds:.0f} s{tests}", flush=True)
    if not results:
        return 0, ""
    text = summary(results)
    print(text)
    return int(not all(result.holds for result in results)), text
