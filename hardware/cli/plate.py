"""The commands `slipscale plate ...`: a table; each is loaded only when called."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import Any

# name: (module that holds it, what it does)
SUBCOMMANDS: dict[str, tuple[str, str]] = {
    "list": ("slipscale.hardware.cli.ports", "the backends, and the ports on which a plate may be"),
    "new": (
        "slipscale.hardware.cli.plate_files",
        "write a plate's own file: identity, limits, wiring",
    ),
    "sign": ("slipscale.hardware.cli.plate_files", "sign a plate's file after a change"),
    "calibrate": ("slipscale.hardware.cli.calibrate", "sweep, fit and write a calibration file"),
    "watch": ("slipscale.hardware.cli.watch", "what a plate says it does, plotted in the terminal"),
    "emulate": (
        "slipscale.hardware.cli.emulate",
        "a driver board on a pseudo-terminal, to try things on",
    ),
    "conform": (
        "slipscale.hardware.cli.conform",
        "hold a driver board against its protocol, rule by rule",
    ),
    "design": ("slipscale.hardware.cli.design", "from requirements to plate sizes"),
}


class _LoadedWhenCalled(ArgumentParser):
    """A subcommand's parser that imports the subcommand's module when it first has to parse."""

    loads: tuple[str, str] | None = None  # module, subcommand

    def parse_known_args(self, *arguments: Any, **options: Any) -> Any:
        if self.loads:
            (module, name), self.loads = self.loads, None
            fill, call = import_module(module).COMMANDS[name]
            fill(self)
            self.set_defaults(call=call)
        return super().parse_known_args(*arguments, **options)


def add_arguments(parser: ArgumentParser) -> None:
    """Fill the parser of ``slipscale plate``."""
    subcommands = parser.add_subparsers(
        metavar="SUBCOMMAND", required=True, parser_class=_LoadedWhenCalled
    )
    for name, (module, purpose) in SUBCOMMANDS.items():
        described = purpose[0].upper() + purpose[1:]
        subcommand = subcommands.add_parser(name, help=purpose, description=described)
        subcommand.loads = (module, name)


def run(arguments: Namespace) -> int:
    """Run the subcommand that was parsed."""
    return int(arguments.call(arguments))
