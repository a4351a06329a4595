"""Command that installs what sessions require: setup."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import sys
from argparse import ArgumentParser, Namespace
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from slipscale.faults import ANSWER_IS_NO, DONE, UserError
from slipscale.faults.extras import no_psychopy

#: Pinned packages of a session, in the wheel: what PsychoPy requires, except 1 GB that no session
#: imports.
PINS = Path(str(files("slipscale"))) / "pins" / "session.txt"


def add_setup(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale setup`` to the parser."""
    commands = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    session = commands.add_parser(
        "session",
        help="show the command that installs PsychoPy and all that sessions, plates, the console "
        "and exports require, at tested versions",
        epilog="example: slipscale setup session",
    )
    session.add_argument(
        "--run", action="store_true", help="run the command: uv's if uv is found, otherwise pip's"
    )


def installers() -> dict[str, list[str]]:
    """Return the command of each installer that this Python can use, uv's first.

    The pins are complete, so the installers add no dependencies of their own.
    """
    rest = ["--no-deps", "-r", str(PINS)]
    found = {}
    if uv := shutil.which("uv"):
        found["uv"] = [uv, "pip", "install", "--python", sys.executable, *rest]
    if find_spec("pip"):
        found["pip"] = [sys.executable, "-m", "pip", "install", *rest]
    return found


def run_setup(args: Namespace) -> int:
    """Print the commands of the installers, or run the first one."""
    if reason := no_psychopy():
        raise UserError(reason)
    found = installers()
    if not found:
        raise UserError(
            "neither pip nor uv is available to {python}; install uv, or pip with: "
            "{python} -m ensurepip",
            python=sys.executable,
        )
    if args.run:
        command = next(iter(found.values()))
        done = subprocess.run(command, check=False)  # noqa: S603 - an installer with our own arguments
        return DONE if done.returncode == 0 else ANSWER_IS_NO
    quoted = subprocess.list2cmdline if sys.platform == "win32" else shlex.join
    for command in found.values():
        print(quoted(command))
    return DONE


COMMANDS = {"setup": (add_setup, run_setup)}
