"""The command line: one table of commands, each loaded only when called.

A command's module offers ``COMMANDS``, a mapping from the command's name to the pair
``(add_arguments, run)``: the first fills an argparse parser, the second takes the parsed
arguments and returns the exit status.
"""

from __future__ import annotations

import os
import sys

from slipscale import __version__
from slipscale.faults import (
    DONE,
    INTERRUPTED,
    RIG_FAULT,
    USER_FAULT,
    RigError,
    UserError,
    harmless,
)

TYPE_CHECKING = False  # typing's own takes milliseconds to import
if TYPE_CHECKING:
    from argparse import ArgumentParser, Namespace
    from collections.abc import Callable

# name: (module that holds it, what it does)
COMMANDS: dict[str, tuple[str, str]] = {
    "pilot": (
        "slipscale.analysis.cli.pilot",
        "whole study, simulated: mock plate, no screen; then analyse",
    ),
    "run": ("slipscale.experiments.cli.sessions", "run a participant's session in PsychoPy"),
    "resume": ("slipscale.experiments.cli.sessions", "go on with an interrupted run"),
    "lab": (
        "slipscale.experiments.cli.lab",
        "the console of a laboratory folder; lab init makes one",
    ),
    "next": (
        "slipscale.experiments.cli.lab",
        "in a laboratory folder: run the next participant's session",
    ),
    "participants": (
        "slipscale.experiments.cli.lab",
        "in a laboratory folder: who is done, who is next",
    ),
    "note": (
        "slipscale.experiments.cli.lab",
        "write the operator's words into the running journal",
    ),
    "check": (
        "slipscale.experiments.cli.sessions",
        "before the participant arrives: is all in order?",
    ),
    "data": (
        "slipscale.experiments.cli.data",
        "data sets: build from the journals, verify against them, withdraw",
    ),
    "analyse": ("slipscale.analysis.cli.analyse", "data set -> tables, figures, report"),
    "export": ("slipscale.analysis.cli.export", "the report for Word, PDF, R and Python"),
    "reproduce": ("slipscale.analysis.cli.reproduce", "the paper's tables and figures beside ours"),
    "reconstruct": (
        "slipscale.analysis.cli.reconstruct",
        "every raw data set that a published table allows",
    ),
    "power": ("slipscale.analysis.cli.power", "how many participants a study needs"),
    "plate": (
        "slipscale.experiments.cli.plate",
        "the machine: calibrate, conform, emulate, design, list",
    ),
    "study": ("slipscale.analysis.cli.study", "study files: new, show, validate, freeze, schema"),
}


def usage() -> str:
    """Return the help text of ``slipscale`` itself."""
    lines = [f"  {name:<12} {purpose}" for name, (_, purpose) in COMMANDS.items()]
    return "\n".join(
        [
            "usage: slipscale COMMAND [ARGUMENT ...]",
            "",
            "Laboratory software for ultrasonic tactile plates.",
            "",
            *lines,
            "",
            "slipscale COMMAND --help says more; slipscale --version says which this is.",
        ]
    )


def main(arguments: list[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : list of str, optional
        The command line after the program's name; ``sys.argv[1:]`` by default.

    Returns
    -------
    int
        0 done; 1 it ran and the answer is no; 2 wrong input; 3 the rig failed; 130 interrupted.
    """
    try:
        status = dispatch(sys.argv[1:] if arguments is None else arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        # Whoever read our output (head, a pager) has had enough; so have we, without complaint.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    return status


def dispatch(words: list[str]) -> int:
    """Answer what needs no command, or call the command; return the exit status."""
    if not words or words[0] in ("-h", "--help", "help"):
        print(usage())
        return DONE if words else USER_FAULT
    if words[0] == "--version":
        print(f"slipscale {__version__}")
        return DONE
    if words[0] not in COMMANDS:
        known = ", ".join(COMMANDS)
        print(f"slipscale: no command '{words[0]}'; there are: {known}", file=sys.stderr)
        return USER_FAULT
    return call(words[0], words[1:])


def load_command(name: str) -> tuple[ArgumentParser, Callable[[Namespace], int]]:
    """Return a command's parser, and the function that runs the command."""
    # Imported here so that `slipscale --help` feels instant.
    from argparse import ArgumentParser  # noqa: PLC0415
    from importlib import import_module  # noqa: PLC0415

    module, purpose = COMMANDS[name]
    parser = ArgumentParser(prog=f"slipscale {name}", description=purpose[0].upper() + purpose[1:])
    add_arguments, run = import_module(module).COMMANDS[name]
    add_arguments(parser)
    return parser, run


def call(name: str, words: list[str]) -> int:
    """Load a command and run it; turn the user's and the rig's faults into one sentence."""
    try:
        parser, run = load_command(name)
        return int(run(parser.parse_args(words)))
    except ModuleNotFoundError as error:
        from slipscale.faults.extras import how_to_install  # noqa: PLC0415 - rarely needed

        if (sentence := how_to_install(error.name or "")) is None:
            raise
        print(f"slipscale {name}: {sentence}", file=sys.stderr)
        return USER_FAULT
    except UserError as error:
        print(f"slipscale {name}: {harmless(str(error))}", file=sys.stderr)
        return USER_FAULT
    except RigError as error:
        print(f"slipscale {name}: {harmless(str(error))}", file=sys.stderr)
        return RIG_FAULT
    except KeyboardInterrupt:
        print(f"slipscale {name}: interrupted", file=sys.stderr)
        return INTERRUPTED
