"""The command ``slipscale plate``, with the laboratory folder's plate as default.

The hardware package does not use laboratory folders, so missing options are filled in here.
"""

from __future__ import annotations

from argparse import Namespace

from slipscale.experiments.lab.defaults import here, say
from slipscale.hardware.cli.plate import add_arguments
from slipscale.hardware.cli.plate import run as run_on


def run(arguments: Namespace) -> int:
    """Run a parsed subcommand; the default plate is the one set in the laboratory folder."""
    if hasattr(arguments, "of_folder") and arguments.plate is None:
        defaults = here()
        say(defaults)
        if defaults.file:
            arguments.plate = arguments.of_folder(defaults.plate)
    return run_on(arguments)


COMMANDS = {"plate": (add_arguments, run)}
