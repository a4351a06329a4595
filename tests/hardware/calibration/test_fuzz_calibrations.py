"""Calibrations as editors and disks leave them: read and used, or refused in a sentence.

A campaign of all such tests: ``make fuzz TEXTS=100000``.
"""

import datetime as dt
from unittest import mock

import pytest
from hypothesis import given
from hypothesis import strategies as st

from faults import RigError, UserError
from hardware.backends.mock import MockPlate
from hardware.calibration import record
from hardware.calibration.record import (
    Device,
    DriveChain,
    Provenance,
    read_calibration,
    to_toml,
)
from hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from hardware.cli.calibrate import measured
from hardware.clock import VirtualClock
from hardware.limits import PlateLimits
from tools.fuzzing import bounded, campaign, changed_file

TODAY = dt.date(2026, 3, 1)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return a calibration's file with few readings, and where the changed ones are put."""
    plate = MockPlate(clock=VirtualClock())
    plate.connect()

    def measure(frequency_hz, voltage_v):
        return measured(plate, plate.excite(frequency_hz=frequency_hz, voltage_v=voltage_v))

    found = calibration_from(
        sweep(SweepPlan(), measure),
        device=Device(backend="mock", serial="twin"),
        made=Provenance(date=TODAY, by="a test", instrument="the twin's own"),
        drive=DriveChain(),
    )
    text = to_toml(found.model_copy(update={"points": found.points[-12:-6]}))
    return text, tmp_path_factory.mktemp("fuzz") / "plate.toml"


@campaign(quick=300)
@given(data=st.data(), signed=st.booleans())
def test_a_calibration_is_used_or_refused_in_a_sentence(whole, data, signed):
    """Of half of them the checksum is taken as it is: a program that changed it computed it."""
    text, path = whole
    path.write_bytes(data.draw(changed_file(text)))
    checksum = record.checksum if signed else lambda _: mock.ANY
    try:
        with bounded(), mock.patch.object(record, "checksum", checksum):
            calibration = read_calibration(path)
            limits = calibration.narrow(PlateLimits())
            volts = calibration.voltage_v_peak(limits.amplitude_um_pp)
            calibration.check_date(TODAY)
            assert calibration.summary()
    except (UserError, RigError) as error:
        assert str(error)  # noqa: PT017 - any sentence
        return
    assert limits.amplitude_um_pp <= PlateLimits().amplitude_um_pp
    assert volts >= 0
    assert to_toml(calibration)


@pytest.mark.parametrize("name", ["frequency_hz", "voltage_v", "amplitude_um_pp"])
@pytest.mark.parametrize("value", ["1e308", "1e-308"])
def test_a_reading_of_no_possible_size_is_refused_in_a_sentence(whole, name, value):
    text, path = whole
    first, *points = text.split("[[points]]")
    lines = [
        f"{name} = {value}" if line.startswith(f"{name} =") else line
        for line in points[2].splitlines()
    ]
    points[2] = "\n".join(lines) + "\n\n"
    path.write_text("[[points]]".join([first, *points]), encoding="utf-8")
    with pytest.raises(UserError, match=r"lie .* from what resonance and gain say|checksum|sha256"):
        read_calibration(path)
