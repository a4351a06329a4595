"""A file that was edited and signed again still has to be possible."""

import re
from datetime import date

import pytest

from slipscale.faults import UserError
from slipscale.hardware.calibration.record import (
    Calibration,
    Device,
    DriveChain,
    Point,
    Provenance,
    write_calibration,
)
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep


def made(**provenance):
    points = sweep(
        SweepPlan(),
        lambda frequency_hz, voltage_v: (
            0.15 * voltage_v / abs(1 + 120j * (frequency_hz - 30_500) / 30_500)
        ),
    )
    return calibration_from(
        points,
        device=Device(backend="scpi", serial="1"),
        made=Provenance(date=date(2026, 1, 1), by="a test", instrument="none", **provenance),
        drive=DriveChain(voltage_convention="V peak", amplifier_gain=2.0),
    )


def signed_again(path, calibration, table, **changes):
    """Write a calibration with changes that no validation has seen, and a correct checksum."""
    part = getattr(calibration, table).model_copy(update=changes)
    write_calibration(calibration.model_copy(update={table: part}), path)
    return path


def test_a_calibration_as_it_was_made_can_be_read(tmp_path):
    write_calibration(made(temperature_c=22.5), tmp_path / "plate.toml")
    found = read_calibration(tmp_path / "plate.toml")
    assert isinstance(found, Calibration)
    assert found.drive.plate_max_v_peak == pytest.approx(16.0)
    assert isinstance(found.points[0], Point)


@pytest.mark.parametrize("temperature_c", [500.0, -300.0, 150.1, -40.1])
def test_a_temperature_that_no_plate_has_is_refused(tmp_path, temperature_c):
    path = signed_again(tmp_path / "plate.toml", made(), "made", temperature_c=temperature_c)
    with pytest.raises(UserError, match="temperature_c"):
        read_calibration(path)


@pytest.mark.parametrize("convention", ["V RMS", "V peak-to-peak"])
def test_a_changed_voltage_convention_is_refused(tmp_path, convention):
    path = signed_again(tmp_path / "plate.toml", made(), "drive", voltage_convention=convention)
    what = rf"voltage_convention is {re.escape(convention)}, but .* with 16 V peak .* at 16 V"
    with pytest.raises(UserError, match=what):
        read_calibration(path)
