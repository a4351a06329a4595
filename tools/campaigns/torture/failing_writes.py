"""Let the n-th call that writes to a data set fail, in a library below Python.

Usage: ``python -m tools.campaigns disk`` (some minutes). Requires Linux and gcc. The library
(``failing_disk.c``) counts the calls below a folder that write, create, rename, truncate, flush or
remove files. One of them fails in each case:

- ``EIO``: this call only; ``EIO from then on``: also all that follow, as on a broken disk,
- ``ENOSPC from then on``: the disk is full; removing still works,
- ``EROFS from then on``: the file system was remounted read-only.

The process may end with a message, not with another exception. The command is then repeated on a
disk without faults, and the result is compared as in the campaign `torture`.
"""

from __future__ import annotations

import ctypes
import errno
import json
import os
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from slipscale.experiments.study.file import shipped_studies
from slipscale.faults import RigError, UserError
from tools.campaigns.torture.pilots import Outcome, looked_up_once, plans_of
from tools.campaigns.torture.system_calls import Strike, strike_campaign
from tools.campaigns.torture.upkeep import strike_upkeep

ONCE, ALWAYS = 1, -1
FAILURES = {
    "EIO": (errno.EIO, ONCE),
    "EIO from then on": (errno.EIO, ALWAYS),
    "ENOSPC from then on": (errno.ENOSPC, ALWAYS),
    "EROFS from then on": (errno.EROFS, ALWAYS),
}


def strikes() -> list[Strike]:
    """Return the failures of a disk; the library must be loaded below this process."""
    library = ctypes.CDLL(None)
    library.calls_made.restype = ctypes.c_long

    def begin_with(error: int, calls: int) -> Callable[[Path, int], Callable[[], int]]:
        def begin(root: Path, at: int) -> Callable[[], int]:
            where = os.fsencode(root)
            library.fail_at(where, ctypes.c_long(at), error, ctypes.c_long(calls))
            return lambda: int(library.calls_made())

        return begin

    raised = (UserError, RigError)
    return [Strike(name, begin_with(*each), raised) for name, each in FAILURES.items()]


def library(folder: Path) -> Path:
    """Compile the library into a folder."""
    path = folder / "failing_disk.so"
    source = Path(__file__).with_name("failing_disk.c")
    command = ["gcc", "-shared", "-fPIC", "-O1", "-o", str(path), str(source), "-ldl"]
    subprocess.run(command, check=True)
    return path


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of the campaign."""
    parser.add_argument("--places", type=int, default=10, help="calls per command (0: all)")
    parser.add_argument("--study", action="append", help="study to run (default: all)")


def run(args: Namespace) -> tuple[int, str]:
    """Run the campaign in a process with the library below it."""
    with TemporaryDirectory(prefix="slipscale-disk-") as folder:
        env = {**os.environ, "LD_PRELOAD": str(library(Path(folder)))}
        words = json.dumps([args.places, args.study or list(shipped_studies())])
        command = [sys.executable, "-m", __name__, words]
        done = subprocess.run(command, env=env, stdout=subprocess.PIPE, text=True, check=False)
    print(done.stdout, end="")
    return done.returncode, done.stdout


def main(words: str) -> int:
    """Run the campaign in this process, and print its table."""
    from tools.campaigns.torture.command import table

    places, studies = json.loads(words)
    outcome = Outcome()
    with looked_up_once():
        for strike in strikes():
            strike_upkeep(places, outcome, strike)
            for study in studies:
                strike_campaign(plans_of(study, 1)[0], places, outcome, strike)
    print("\n".join(table(outcome)))
    for _, sentence in outcome.bad:
        print(sentence, file=sys.stderr)
    return int(bool(outcome.bad))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
