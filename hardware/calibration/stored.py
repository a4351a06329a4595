"""Read calibration files, and check that they are complete, unchanged and consistent."""

from __future__ import annotations

import math
from pathlib import Path

from slipscale.faults import UserError
from slipscale.faults.toml_file import read_toml
from slipscale.hardware.calibration import record
from slipscale.hardware.calibration.record import CHECKSUM, Calibration
from slipscale.hardware.calibration.sweep import fitted

REFITTED = 1e-6  # allowed relative difference between stored and refitted results


class _Signed(Calibration):
    sha256: str = ""


def read_calibration(path: Path) -> Calibration:
    """Read and validate a calibration file.

    Raises
    ------
    UserError
        If the file does not exist, is not valid TOML or was changed after it was written, or if
        values are missing or impossible.
    """
    signed = read_toml(path, _Signed)
    calibration = Calibration.model_validate(signed.model_dump(exclude={CHECKSUM}))
    if signed.sha256 != record.checksum(calibration):
        raise UserError(
            "calibration '{path}' was changed after it was written: its {checksum} is missing or "
            "does not match its content; fit the readings again with slipscale plate calibrate "
            "--csv",
            path=path,
            checksum=CHECKSUM,
        )
    _require_refit(calibration, path)
    return calibration


def _require_refit(calibration: Calibration, path: Path) -> None:
    """Raise `UserError` if a new fit of the stored readings gives different results."""
    resonance, gain = fitted(calibration.points)
    for table, stored, found in (
        ("resonance", calibration.resonance, resonance),
        ("gain", calibration.gain, gain),
    ):
        for name in type(stored).model_fields:
            values, refitted = getattr(stored, name), getattr(found, name)
            if not math.isclose(values, refitted, rel_tol=REFITTED, abs_tol=1e-9):
                raise UserError(
                    "calibration '{path}': {table}.{name} is {values:g}, but the stored readings "
                    "give {refitted:g}; restore the file, or fit the readings again with "
                    "slipscale plate calibrate --csv",
                    path=path,
                    table=table,
                    name=name,
                    values=values,
                    refitted=refitted,
                )
