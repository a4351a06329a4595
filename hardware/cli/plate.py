"""Implement `slipscale plate`; subcommands are imported only when called."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from slipscale.faults.parser import Parser

# Module and description, keyed by name.
SUBCOMMANDS: dict[str, tuple[str, str]] = {
    "list": (
        "slipscale.hardware.cli.ports",
        "list the backends, and the ports to which a plate may be connected",
    ),
    "new": (
        "slipscale.hardware.cli.plate_files",
        "create a plate file with identity, limits and wiring",
    ),
    "sign": (
        "slipscale.hardware.cli.plate_files",
        "sign a plate file after a change",
    ),
    "calibrate": (
        "slipscale.hardware.cli.calibrate",
        "sweep, fit and write a calibration file",
    ),
    "watch": (
        "slipscale.hardware.cli.watch",
        "plot a plate's readback in the terminal",
    ),
    "emulate": (
        "slipscale.hardware.cli.emulate",
        "emulate a driver board on a pseudo-terminal, for experiments without a plate",
    ),
    "conform": (
        "slipscale.hardware.cli.conform",
        "check a driver board against its protocol, rule by rule",
    ),
    "design": (
        "slipscale.hardware.cli.design",
        "compute plate sizes from requirements",
    ),
}
EXAMPLES = {
    "list": "slipscale plate list",
    "new": "slipscale plate new plates/desk.toml --backend serial",
    "sign": "slipscale plate sign plates/desk.toml",
    "calibrate": "slipscale plate calibrate --plate mock --by Ada --instrument vibrometer",
    "watch": "slipscale plate watch mock --seconds 1",
    "emulate": "slipscale plate emulate --finger",
    "conform": "slipscale plate conform serial:/dev/ttyACM0",
    "design": "slipscale plate design",
}


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of ``slipscale plate``."""
    subcommands = parser.add_subparsers(
        dest="what", metavar="SUBCOMMAND", required=True, parser_class=Parser
    )
    for name, (module, purpose) in SUBCOMMANDS.items():
        described = purpose[0].upper() + purpose[1:]
        subcommand = subcommands.add_parser(
            name, help=purpose, description=described, epilog=f"example: {EXAMPLES[name]}"
        )
        subcommand.loads = (module, name)


def run(arguments: Namespace) -> int:
    """Run the parsed subcommand."""
    return int(arguments.call(arguments))
