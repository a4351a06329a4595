"""Run every line of docs/reliability.md: each promise, by the command that stands beside it.

Use: ``make reliability``. Prints a line for each promise; exit status 1 where one does not hold.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "reliability.md"
ROW = re.compile(r"\| (?P<promise>[^|]+) \| (?P<how>[^|]+) \| `(?P<command>[^`|]+)` \|")


@dataclass(frozen=True)
class Promise:
    """A line of the page: what is promised, and the command that shows it."""

    text: str
    command: str


def promises() -> list[Promise]:
    """Return the page's promises, in order."""
    found = (ROW.fullmatch(line) for line in PAGE.read_text(encoding="utf-8").splitlines())
    return [Promise(row["promise"], row["command"]) for row in found if row]


def holds(promise: Promise) -> bool:
    """Run a promise's command; return whether it says that all is well."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    done = subprocess.run(
        ["sh", "-c", promise.command],  # a line of our own page, as a reader would type it
        cwd=ROOT,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        print(done.stdout[-4000:], done.stderr[-4000:], file=sys.stderr)
    return done.returncode == 0


def main() -> int:
    """Run every promise's command; return 1 where one fails."""
    failed = 0
    for promise in promises():
        began_s = time.monotonic()
        kept = holds(promise)
        failed += not kept
        word = "holds" if kept else "FAILS"
        print(f"{word}  {time.monotonic() - began_s:6.0f} s  {promise.text}", flush=True)
        print(f"                 {promise.command}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
