"""The front door: one table of commands, each loaded only when called.

A command's module offers ``COMMANDS``, a mapping from the command's name to the pair
``(add_arguments, run)``: the first fills an argparse parser, the second takes the parsed
arguments and returns the exit status.
"""

from __future__ import annotations

import os
import sys
from importlib.machinery import PathFinder

VERSION = "0.1.0"

# The packages beside this file. Their names are common ones: see docs/your-own-analysis-folder.md.
PACKAGES = ("analysis", "experiments", "hardware", "stimuli", "figure_style", "faults")


def hidden_package() -> str | None:
    """Return a sentence if Python imports a file of the user's in place of one of our packages."""
    ours = os.path.dirname(os.path.abspath(__file__))  # noqa: PTH100, PTH120 - pathlib takes 5 ms
    for name in PACKAGES:
        module = sys.modules.get(name)
        spec = module.__spec__ if module else PathFinder.find_spec(name)
        found = spec.origin if spec else None
        own = f"{ours}{os.sep}{name}{os.sep}__init__.py"
        # The paths differ where one of them goes through a symbolic link.
        if found != own and (found is None or os.path.realpath(found) != os.path.realpath(own)):
            return (
                f"'import {name}' finds {found or 'no file'}, not the package of Slipscale in "
                f"{ours}. Rename your file or folder '{name}', or move your script away from it; "
                "if PYTHONPATH or sys.path names its folder, take it out there"
            )
    return None


if (HIDDEN := hidden_package()) is not None:
    # The command tells it in a sentence, as every fault of the user's; a script gets an exception.
    if __name__ == "__main__" or os.path.basename(sys.argv[0]) in ("slipscale", "slipscale.exe"):  # noqa: PTH119
        print(f"slipscale: {HIDDEN}", file=sys.stderr)
        sys.exit(2)  # faults.USER_FAULT, which may be what cannot be imported
    raise ImportError(HIDDEN)

from faults import (  # noqa: E402
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
    "pilot": ("analysis.cli.pilot", "whole study, simulated: mock plate, no screen; then analyse"),
    "run": ("experiments.cli.sessions", "run a participant's session in PsychoPy"),
    "resume": ("experiments.cli.sessions", "go on with an interrupted run"),
    "lab": ("experiments.cli.lab", "the console of a laboratory folder; lab init makes one"),
    "next": ("experiments.cli.lab", "in a laboratory folder: run the next participant's session"),
    "participants": ("experiments.cli.lab", "in a laboratory folder: who is done, who is next"),
    "note": ("experiments.cli.lab", "write the operator's words into the running journal"),
    "check": ("experiments.cli.sessions", "before the participant arrives: is all in order?"),
    "data": (
        "experiments.cli.data",
        "data sets: build from the journals, verify against them, withdraw",
    ),
    "analyse": ("analysis.cli.analyse", "data set -> tables, figures, report"),
    "export": ("analysis.cli.export", "the report for Word, PDF, R and Python"),
    "reproduce": ("analysis.cli.reproduce", "the paper's tables and figures beside ours"),
    "reconstruct": (
        "analysis.cli.reconstruct",
        "every raw data set that a published table allows",
    ),
    "power": ("analysis.cli.power", "how many participants a study needs"),
    "plate": ("experiments.cli.plate", "the machine: calibrate, conform, emulate, design, list"),
    "study": ("analysis.cli.study", "study files: new, show, validate, freeze, schema"),
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
        print(f"slipscale {VERSION}")
        return DONE
    if words[0] not in COMMANDS:
        known = ", ".join(COMMANDS)
        print(f"slipscale: no command '{words[0]}'; there are: {known}", file=sys.stderr)
        return USER_FAULT
    return call(words[0], words[1:])


def load(name: str) -> tuple[ArgumentParser, Callable[[Namespace], int]]:
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
        parser, run = load(name)
        return int(run(parser.parse_args(words)))
    except ModuleNotFoundError as error:
        from faults.extras import how_to_install  # noqa: PLC0415 - rarely needed

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


if __name__ == "__main__":
    sys.exit(main())
