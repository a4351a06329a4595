"""Run a slipscale command only while somebody holds its standard input open.

The console holds the other end of the pipe while a page of the plate bench is open. When the page
is closed, or the console ends or is killed, the pipe ends, and the command gets the signal on
which it switches the plate off (`slipscale.hardware.signals`).

Usage: python -m slipscale.experiments.lab.console.held COMMAND [ARGUMENT ...]
"""

from __future__ import annotations

import _thread
import os
import runpy
import signal
import sys
from threading import Thread


def _end_with_input() -> None:
    """Wait until standard input ends; then have the main thread end as by SIGTERM."""
    while os.read(sys.__stdin__.fileno() if sys.__stdin__ else 0, 1):
        pass
    if sys.platform == "win32":
        _thread.interrupt_main()  # a signal would end the process without switching off
    else:
        os.kill(os.getpid(), signal.SIGTERM)


def main() -> None:
    """Run the command of the arguments."""
    Thread(target=_end_with_input, name="held", daemon=True).start()
    runpy.run_module("slipscale", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
