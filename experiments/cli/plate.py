"""The command ``slipscale plate``: that of the hardware, on the laboratory folder's plate.

The hardware knows no laboratory folder; what it asks for and the command line leaves open is
filled in here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from slipscale.experiments.lab.defaults import here, say
from slipscale.hardware.cli.plate import add_arguments
from slipscale.hardware.cli.plate import run as run_on

if TYPE_CHECKING:
    from argparse import Namespace


def run(arguments: Namespace) -> int:
    """Run the subcommand that was parsed, on the folder's plate where none is named."""
    if getattr(arguments, "plate", "") is None:
        defaults = here()
        say(defaults)
        if defaults.file:
            arguments.plate = arguments.of_folder(defaults.plate)
    return run_on(arguments)


COMMANDS = {"plate": (add_arguments, run)}
