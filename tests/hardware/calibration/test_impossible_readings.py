"""Readings that no plate can have."""

import pytest

from slipscale.faults import UserError
from slipscale.hardware.calibration.record import to_toml
from slipscale.hardware.calibration.stored import read_calibration
from tests.fuzzing.calibrations import whole_calibration


@pytest.mark.parametrize("name", ["frequency_hz", "voltage_v", "amplitude_um_pp"])
@pytest.mark.parametrize("value", ["1e308", "1e-308"])
def test_a_reading_of_no_possible_size_is_refused_in_a_sentence(tmp_path, name, value):
    path = tmp_path / "plate.toml"
    first, *points = to_toml(whole_calibration()).split("[[points]]")
    lines = [
        f"{name} = {value}" if line.startswith(f"{name} =") else line
        for line in points[2].splitlines()
    ]
    points[2] = "\n".join(lines) + "\n\n"
    path.write_text("[[points]]".join([first, *points]), encoding="utf-8")
    with pytest.raises(
        UserError,
        match=r"differ by .* from the fitted resonance and gain|checksum|sha256|was made at",
    ):
        read_calibration(path)
