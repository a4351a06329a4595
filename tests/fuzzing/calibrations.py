"""Fuzz calibrations, which a plate must use or reject with an error message."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from pathlib import Path
from random import Random
from unittest import mock

from slipscale.faults import RigError, UserError
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.calibration import record
from slipscale.hardware.calibration.record import (
    Calibration,
    Device,
    DriveChain,
    Provenance,
    to_toml,
)
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from slipscale.hardware.cli.calibrate import measured
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.limits import PlateLimits
from tests.fuzzing.changes import changed_file
from tests.fuzzing.kind import Case, Kind

TODAY = dt.date(2026, 3, 1)


def whole_calibration() -> Calibration:
    """Return the mock plate's calibration from a short sweep."""
    plate = MockPlate(clock=VirtualClock())
    plate.connect()

    def measure(frequency_hz: float, voltage_v: float) -> float:
        return measured(plate, plate.excite(frequency_hz=frequency_hz, voltage_v=voltage_v))

    points = sweep(SweepPlan(), measure)
    return calibration_from(
        [each for each in points if each.sweep != "coarse"][::4],
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=TODAY, by="a test", instrument="the twin's own"),
        drive=DriveChain(),
    )


def _prepared(folder: Path) -> Callable[[Random], Case]:
    path = folder / "calibration.toml"
    text = to_toml(whole_calibration())

    def drawn(random: Random) -> Case:
        content = changed_file(random, text)
        # Half of the files pass the checksum test, as if the checksum had been recomputed.
        signed = random.randrange(2) == 0
        return Case(name=path.name, content=content, use=lambda: _use(path, content, signed=signed))

    return drawn


def _use(path: Path, content: bytes, *, signed: bool) -> bool:
    path.write_bytes(content)
    checksum = record.checksum if signed else lambda _: mock.ANY
    try:
        with mock.patch.object(record, "checksum", checksum):
            calibration = read_calibration(path)
            limits = calibration.narrow(PlateLimits())
            volts = calibration.voltage_v_peak(limits.level)
            calibration.check_date(TODAY)
    except (UserError, RigError) as error:
        return not str(error)
    if limits.level > PlateLimits().level or not volts >= 0:
        raise AssertionError(f"{limits}, {volts} V")
    if not (calibration.summary() and to_toml(calibration)):
        raise AssertionError("nothing to say of it")
    return True


KIND = Kind(title="calibrations", prepared=_prepared)
