"""The commands `slipscale plate ...`: a table; each is loaded only when called."""

from __future__ import annotations

from argparse import REMAINDER, ArgumentParser, Namespace, RawDescriptionHelpFormatter
from importlib import import_module

# name: (module that holds it, what it does)
SUBCOMMANDS: dict[str, tuple[str, str]] = {
    "list": ("hardware.cli.ports", "the backends, and the ports on which a plate may be"),
    "calibrate": ("hardware.cli.calibrate", "sweep, fit and write a calibration file"),
    "emulate": ("hardware.cli.emulate", "a driver board on a pseudo-terminal, to try things on"),
    "design": ("hardware.cli.design", "from requirements to plate sizes"),
}


def add_arguments(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale plate``: what follows the subcommand is its own."""
    parser.usage = "slipscale plate SUBCOMMAND [ARGUMENT ...]"
    parser.formatter_class = RawDescriptionHelpFormatter
    lines = [f"  {name:<9}  {purpose}" for name, (_, purpose) in SUBCOMMANDS.items()]
    parser.epilog = "\n".join(
        ["subcommands:", *lines, "", "slipscale plate SUBCOMMAND --help says more."]
    )
    parser.add_argument("subcommand", choices=[*SUBCOMMANDS], metavar="SUBCOMMAND")
    parser.add_argument("rest", nargs=REMAINDER, metavar="ARGUMENT")


def run(arguments: Namespace) -> int:
    """Load the subcommand and run it."""
    name = arguments.subcommand
    module, purpose = SUBCOMMANDS[name]
    parser = ArgumentParser(
        prog=f"slipscale plate {name}", description=purpose[0].upper() + purpose[1:]
    )
    fill, call = import_module(module).COMMANDS[name]
    fill(parser)
    return int(call(parser.parse_args(arguments.rest)))


COMMANDS = {"plate": (add_arguments, run)}
