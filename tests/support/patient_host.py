"""A computer whose time-outs are long, for tests with real ports, which a busy machine delays.

    python -m tests.support.patient_host plate watch serial:PORT

runs a command of Slipscale on it.
"""

from __future__ import annotations

import sys

from slipscale import commands
from slipscale.hardware.backends.serial_board import host

SLOWNESS = 100.0


class PatientHost(host.SystemHost):
    """Computer with a slow clock: a time-out of 80 ms is 8 s. The heart beats as usual."""

    def now(self) -> float:
        """Return the time in units of `SLOWNESS` seconds."""
        return super().now() / SLOWNESS


if __name__ == "__main__":
    host.SystemHost = PatientHost
    sys.exit(commands.main(sys.argv[1:]))
