"""A simulated plate that writes its level to a file, so that another process can read it.

Unlike an emulated board, it has no watchdog, which a slow machine could miss. Only a process that
switches its plate off leaves a silent plate.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from slipscale.hardware.backends import mock

if TYPE_CHECKING:
    from slipscale.hardware.clock import Clock
    from slipscale.hardware.driver import PlateDriver
    from slipscale.hardware.plate.twin import Drive


class _Plate(mock.MockPlate):
    name = "reported"
    file: Path

    def _set(self, drive: Drive) -> None:
        super()._set(drive)
        draft = self.file.with_suffix(".new")
        draft.write_text(str(drive.target_um_pp or 0.0), encoding="utf-8")
        draft.replace(self.file)


def open_plate(address: str, *, clock: Clock, seed: int) -> PlateDriver:
    """Return a driver whose level is written to the file named by the address."""
    plate = mock.open_plate("", clock=clock, seed=seed)
    plate.__class__ = _Plate
    vars(plate)["file"] = Path(address)
    return plate


class ReportedPlate:
    """Install the backend ``reported`` for processes that are started with its environment.

    Parameters
    ----------
    folder : Path
        An empty folder for the installation and the file.

    Attributes
    ----------
    spec : str
        SPEC of the plate.
    environment : dict
        Environment variables of processes that use the plate.
    """

    def __init__(self, folder: Path) -> None:
        info = folder / "reported-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Name: reported\nVersion: 1.0\n", encoding="utf-8")
        (info / "entry_points.txt").write_text(
            "[slipscale.backends]\nreported = reported_plate:open_plate\n", encoding="utf-8"
        )
        self._level = folder / "level.txt"
        self.spec = f"reported:{self._level}"
        paths = [str(folder), str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
        self.environment = {"PYTHONPATH": os.pathsep.join(filter(None, paths))}

    def vibrates(self) -> bool:
        """Return whether the plate is switched on."""
        return self._level.exists() and float(self._level.read_text(encoding="utf-8")) != 0.0
