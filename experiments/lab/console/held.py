"""Run a slipscale command only as long as its standard input stays open.

The console keeps its end of the input pipe open while a plate bench page is open. When the page or
the console is closed, the pipe closes, and the command receives the signal to switch the plate off
(`slipscale.hardware.signals`).

Data written to the pipe are passed to the command's standard input.

Usage: python -m slipscale.experiments.lab.console.held COMMAND [ARGUMENT ...]
"""

from __future__ import annotations

import _thread
import os
import runpy
import signal
import sys
from threading import Thread

STANDARD_INPUT = 0


def _pass_on(held: int, command: int) -> None:
    """Forward standard input to the command, and stop the command at the end of the input."""
    while content := os.read(held, 1000):
        os.write(command, content)
    if sys.platform == "win32":
        _thread.interrupt_main()  # a signal would end the process without switching the plate off
    else:
        os.kill(os.getpid(), signal.SIGTERM)


def main() -> None:
    """Run the command given by the arguments."""
    held = os.dup(STANDARD_INPUT)
    read, write = os.pipe()
    os.dup2(read, STANDARD_INPUT)
    Thread(target=_pass_on, args=(held, write), name="held", daemon=True).start()
    runpy.run_module("slipscale", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
