"""A data acquisition device that outlives its processes: its state is in files.

A program uses it in place of ``nidaqmx`` if its path contains a module of that name, which
`install` writes. Like a real device, the device plays on when the process of its task is killed or
stopped, and a task reserves the output against all other processes until it ends.
"""

from __future__ import annotations

import os
import sys
import time
from contextlib import suppress
from pathlib import Path
from types import ModuleType, SimpleNamespace

from slipscale.hardware.backends import daq_device
from slipscale.hardware.backends.daq_device import AcquisitionType, Error

FOLDER = "SLIPSCALE_TEST_DAQ"
__all__ = ["Task", "constants", "errors", "system"]
errors = SimpleNamespace(Error=Error)
constants = SimpleNamespace(AcquisitionType=AcquisitionType)


def install(folder: Path) -> dict[str, str]:
    """Write the module ``nidaqmx``, and return the environment of programs that use it."""
    (folder / "nidaqmx.py").write_text("from tests.support.nidaqmx_on_disk import *\n", "utf-8")
    root = Path(__file__).parents[2]
    path = os.pathsep.join([str(folder), str(root), os.environ.get("PYTHONPATH", "")])
    return {**os.environ, "PYTHONPATH": path, FOLDER: str(folder)}


def record(folder: Path) -> list[tuple[float, float]]:
    """Return the outputs since the device was installed: monotonic time, largest voltage."""
    with suppress(FileNotFoundError):
        lines = (folder / "output.txt").read_text("utf-8").splitlines()
        return [(float(time_s), float(volt)) for time_s, volt in map(str.split, lines)]
    return []


class _Device(daq_device.Terminals):
    def __init__(self) -> None:
        self._folder = Path(os.environ.get(FOLDER, "."))
        super().__init__()

    @property
    def output_v(self) -> list[float]:
        return self._played

    @output_v.setter
    def output_v(self, volts: list[float]) -> None:
        self._played = volts
        with (self._folder / "output.txt").open("a", encoding="utf-8") as file:
            file.write(f"{time.monotonic()} {max(map(abs, volts))}\n")

    @property
    def reserved(self) -> bool:
        with suppress(OSError, ValueError):
            process = int((self._folder / "reserved.txt").read_text("utf-8"))
            os.kill(process, 0)
            return Path(f"/proc/{process}/stat").read_text("utf-8").split()[2] != "Z"
        return False

    @reserved.setter
    def reserved(self, reserved: bool) -> None:
        (self._folder / "reserved.txt").write_text(str(os.getpid()) if reserved else "", "utf-8")

    def reset_device(self) -> None:
        """Abort all tasks, also those of other processes; the output keeps its voltage."""
        self.reserved = False


if FOLDER in os.environ:
    daq_device.TERMINALS = _Device.__new__(_Device)
    daq_device.TERMINALS._folder = Path(os.environ[FOLDER])
    daq_device.TERMINALS._played = [0.0]
    daq_device.TERMINALS.unplugged, daq_device.TERMINALS.wired = False, True
Task = daq_device.Task
system = ModuleType("nidaqmx.system")
system.Device = lambda _name: daq_device.TERMINALS
sys.modules["nidaqmx.system"] = system
