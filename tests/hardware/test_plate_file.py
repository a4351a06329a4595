"""A plate's own file: written, edited, signed, and what a driver makes of it."""

import dataclasses
import datetime as dt
import json
import re

import pytest

from slipscale import commands
from slipscale.faults import UserError
from slipscale.hardware.address import Plate, with_plate_file
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.calibration.record import Device, DriveChain, Provenance, write_calibration
from slipscale.hardware.calibration.stored import read_calibration
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import OverLimit, WrongDevice
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.twin import Twin
from slipscale.hardware.plate_file import LimitsTable, open_plate_file
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

TODAY = dt.datetime.now(tz=dt.UTC).date()


STUDY = """
name = "desk"
title = "On the plate of the desk"
participants = 1
amplitudes_um_pp = [0.5, 2.3]

[plate]
file = "PLATE"

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0
randomisation = "blocked"
"""


class Real(MockPlate):
    """A twin that passes for a plate at which a finger may be."""

    simulated = False


@pytest.fixture
def file(tmp_path):
    """A plate file for the mock, as `slipscale plate new` writes it."""
    path = tmp_path / "plates" / "desk.toml"
    assert commands.main(["plate", "new", str(path), "--backend", "mock", "--serial", "P-7"]) == 0
    return path


def edit(path, before, after):
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def sign(path, *words):
    return commands.main(["plate", "sign", str(path), *words])


def opened(path):
    return open_plate(f"mock:plate={path}", clock=VirtualClock())


def calibrate(folder, **device):
    twin = Twin(seed=1)
    now = twin.conditions(0)
    found = calibration_from(
        sweep(SweepPlan(), lambda hz, v: abs(now.response_um_pp_per_v(hz)) * v),
        device=Device(**{"backend": "mock", "plate": "P-7", "serial": "twin"} | device),
        made=Provenance(date=TODAY, by="a test", instrument="none"),
        drive=DriveChain(),
    )
    write_calibration(found, folder / "calibration.toml")


def test_a_new_file_has_the_shipped_limits_and_opens(file):
    plate, calibration = open_plate_file(file)
    assert plate.identity.name == "desk"
    assert plate.plate_limits() == PlateLimits()
    assert calibration is None
    with opened(file) as driver:
        assert driver.describe()["plate_file"]["identity"]["serial"] == "P-7"
        json.dumps(driver.describe())


def test_its_limits_are_those_of_the_shipped_class():
    names = [each.name for each in dataclasses.fields(PlateLimits)]
    names[names.index("voltage_v")] = "voltage_v_peak"
    assert set(names) == {*LimitsTable.model_fields, "quantity"}


def test_an_existing_file_is_never_overwritten(file, capsys):
    assert commands.main(["plate", "new", str(file), "--backend", "mock"]) == 2
    assert "File exists" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words, said",
    [
        (["desk", "--backend", "mock"], "ends in .toml"),
        (["desk.toml", "--backend", "nothing"], "expected one of"),
        (["my desk.toml", "--backend", "mock"], "got 'my desk'"),
        (
            ["desk.toml", "--backend", "scpi", "--amplifier-gain", "-3"],
            "expected a number above 0, got -3.0",
        ),
    ],
)
def test_a_new_file_that_cannot_be_is_refused_in_a_sentence(tmp_path, words, said, capsys):
    assert commands.main(["plate", "new", str(tmp_path / words[0]), *words[1:]]) == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_change_counts_only_when_it_is_signed_and_comments_stay(file):
    edit(file, "amplitude_um_pp = 2.5", "amplitude_um_pp = 1.0  # it is cracked")
    with pytest.raises(UserError, match=r"was changed after it was signed; .*plate sign"):
        opened(file)
    assert sign(file) == 0
    with opened(file) as driver:
        driver.present(VirtualSurface(level=1.0))
        with pytest.raises(OverLimit):
            driver.present(VirtualSurface(level=1.1))
    assert "# it is cracked" in file.read_text(encoding="utf-8")
    assert "After a change, run:\n# slipscale plate sign " in file.read_text(encoding="utf-8")


def test_limits_beyond_the_shipped_ones_need_an_acknowledgement_by_name(file, capsys):
    edit(file, "amplitude_um_pp = 2.5", "amplitude_um_pp = 4.0")
    edit(file, "voltage_v_peak = 16.5", "voltage_v_peak = 30.0")
    assert sign(file) == 2
    assert "amplitude_um_pp = 4, voltage_v_peak = 30 is beyond" in capsys.readouterr().err
    assert sign(file, "--beyond-shipped-limits") == 2
    with pytest.raises(UserError, match="beyond the shipped limits"):
        opened(file)
    assert sign(file, "--beyond-shipped-limits", "--by", "Dr. A. Limit") == 0
    assert "beyond the shipped limits: voltage_v_peak = 30" in capsys.readouterr().out
    with opened(file) as driver:
        made = driver.present(VirtualSurface(level=4.0))
        assert made.readback.level == pytest.approx(4, abs=0.05)
        told = driver.describe()["plate_file"]["acknowledgement"]
        assert told["by"] == "Dr. A. Limit"
        assert told["limits"] == {"amplitude_um_pp": 4.0, "voltage_v_peak": 30.0}
        assert driver.describe()["limits"]["level"] == 4.0


def test_an_acknowledgement_that_was_written_by_hand_is_not_signed(file, capsys):
    edit(file, "amplitude_um_pp = 2.5", "amplitude_um_pp = 4.0")
    assert sign(file, "--beyond-shipped-limits", "--by", "A. Name") == 0
    for before, after in (
        ('by = "A. Name"', 'by = "B. Else"'),
        ("amplitude_um_pp = 4.0", "amplitude_um_pp = 5.0"),
    ):
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace(before, after), "utf-8")
        assert sign(file) == 2
        assert "typed into the file is not accepted" in capsys.readouterr().err
    assert sign(file, "--beyond-shipped-limits", "--by", "B. Else") == 0
    edit(file, 'by = "B. Else"', 'by = "B. Else"  # a comment is free')
    assert sign(file) == 0


def test_an_acknowledgement_holds_for_its_own_values_only(file):
    edit(file, "amplitude_um_pp = 2.5", "amplitude_um_pp = 4.0")
    assert sign(file, "--beyond-shipped-limits", "--by", "A") == 0
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace("amplitude_um_pp = 4.0", "amplitude_um_pp = 5.0", 1), "utf-8")
    assert sign(file) == 2
    with pytest.raises(UserError, match="amplitude_um_pp = 5 is beyond the shipped limits"):
        opened(file)
    edit(file, "amplitude_um_pp = 5.0", "amplitude_um_pp = 2.0")
    assert sign(file) == 0
    assert "acknowledgement" not in file.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "name, value, wider",
    [
        ("frequency_min_hz", 24_000.0, True),
        ("frequency_min_hz", 26_000.0, False),
        ("frequency_max_hz", 41_000.0, True),
        ("on_time_s", 601.0, True),
        ("tolerance", 0.2, True),
        ("duty", 0.5, False),
    ],
)
def test_what_is_wider_than_shipped(name, value, wider):
    assert LimitsTable(**{name: value}).beyond_shipped() == ({name: value} if wider else {})


def test_a_plate_in_um_keeps_the_shipped_limits_whatever_participants_judge(file):
    edit(file, "[limits]", '[quantity]\njudged = "roughness"\n\n[limits]')
    assert sign(file) == 0
    with opened(file) as driver:
        assert driver.limits == dataclasses.replace(PlateLimits(), quantity=driver.limits.quantity)


def test_a_study_names_its_plate_and_another_one_is_refused():
    assert (
        with_plate_file("serial:COM3,attention=9", "desk") == "serial:COM3,attention=9,plate=desk"
    )
    with pytest.raises(UserError, match="the study is for plate 'desk', not 'chair'"):
        with_plate_file("serial:COM3,plate=chair", "desk")


def test_a_pilot_holds_to_the_limits_of_the_studys_plate_and_says_whose_they_are(
    file, tmp_path, capsys
):
    edit(file, "amplitude_um_pp = 2.5", "amplitude_um_pp = 1.0")
    sign(file)
    study = tmp_path / "study.toml"
    study.write_text(STUDY.replace("PLATE", str(file)), encoding="utf-8")
    words = ["pilot", str(study), "--participants", "1", "--out", str(tmp_path / "data")]
    assert commands.main(words) == 3
    assert "2.3 µm p-p is outside 0 to" in capsys.readouterr().err
    study.write_text(STUDY.replace("PLATE", str(file)).replace("2.3", "0.9"), encoding="utf-8")
    assert commands.main(words) == 0
    [journal] = (tmp_path / "data").glob("sourcedata/sub-01/*.jsonl")
    header = json.loads(journal.read_text(encoding="utf-8").splitlines()[0])
    assert header["plate_spec"] == f"mock:plate={file}"
    assert header["plate"]["plate_file"]["identity"]["serial"] == "P-7"


def test_a_plate_is_found_by_its_name_in_the_folder_plates(file, monkeypatch):
    monkeypatch.chdir(file.parent.parent)
    with opened("desk") as driver:
        assert driver.plate_file.identity.name == "desk"
    with pytest.raises(UserError, match="cannot be read"):
        opened("chair")


def test_a_file_of_another_backend_or_device_is_refused(file):
    with pytest.raises(UserError, match="is for backend 'mock'"):
        open_plate(f"serial:/dev/ttyACM0,plate={file}", clock=VirtualClock())
    edit(file, 'device_serial = ""', 'device_serial = "0042"')
    assert sign(file) == 0
    with pytest.raises(WrongDevice, match="for device '0042', but this is 'twin'"):
        Real(clock=VirtualClock(), plate=Plate(file=open_plate_file(file)[0])).connect()
    with opened(file) as driver:  # on the twin a study for any plate can be rehearsed
        assert driver.identity.serial == "twin"


def test_a_calibration_takes_the_plates_number_from_its_file(file, capsys):
    out = file.parent / "calibration.toml"
    spec = ["--plate", f"mock:plate={file}", "--out", str(out)]
    words = ["plate", "calibrate", "--by", "A", "--instrument", "B", *spec]
    assert commands.main([*words, "--plate-serial", "P-8"]) == 2
    assert "the plate file has serial number 'P-7'" in capsys.readouterr().err
    assert commands.main(words) == 0
    assert read_calibration(out).device.plate == "P-7"


def test_its_calibration_comes_with_it(file):
    calibrate(file.parent)
    edit(file, "# [calibration]\n# file", "[calibration]\nfile")
    assert sign(file) == 0
    with opened(file) as driver:
        assert driver.describe()["calibration"]["device"]["plate"] == "P-7"
        assert driver.notes == ()


def test_a_calibration_whose_name_no_file_can_have_is_refused(file):
    file.write_text(f'{file.read_text()}[calibration]\nfile = "a\\u0000b"\n')
    commands.main(["plate", "sign", str(file)])
    with pytest.raises(UserError, match="a file name cannot contain a null character"):
        open_plate_file(file)


@pytest.mark.parametrize(
    "device, expected, said",
    [
        ({"plate": "P-8"}, "", "made on plate 'P-8', but the plate file has 'P-7'"),
        ({"backend": "scpi"}, "", "made on backend 'scpi'"),
        ({}, "quality_factor = [100, 200]", "quality_factor is 60, but the plate file expects 100"),
        ({}, "resonance_hz = [31000, 32000]", "resonance_hz is 30"),
        ({}, "um_pp_per_v_peak = [0.01, 0.02]", "um_pp_per_v_peak is 0.153333"),
    ],
)
def test_a_calibration_that_is_not_this_plates_is_refused(file, device, expected, said):
    calibrate(file.parent, **device)
    edit(file, "# [calibration]\n# file", "[calibration]\nfile")
    if expected:
        name = expected.split(" ")[0]
        text = file.read_text(encoding="utf-8")
        file.write_text(re.sub(rf"^{name} = .*$", expected, text, flags=re.MULTILINE), "utf-8")
    assert sign(file) == 0
    with pytest.raises(UserError, match="does not belong to this plate") as caught:
        opened(file)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "gain, channel, spec, said",
    [
        ("20", "", ",gain=10", "the SPEC has 10, the plate file has 20"),
        (
            "20",
            "channel = 2",
            ",channel=1",
            "the SPEC has channel=1, but the plate file has channel 2",
        ),
    ],
)
def test_wiring_and_spec_that_differ_are_refused(tmp_path, gain, channel, spec, said):
    path = tmp_path / "lan.toml"
    words = ["plate", "new", str(path), "--backend", "scpi", "--amplifier-gain", gain]
    assert commands.main(words) == 0
    edit(path, "amplifier_gain", f"{channel}\namplifier_gain")
    assert sign(path) == 0
    plate = open_plate(f"scpi:/dev/ttyUSB0,plate={path}", clock=VirtualClock())
    assert plate.amplifier_gain == 20
    assert plate._output.channel == (2 if channel else 1)
    with pytest.raises(UserError, match=said):
        open_plate(f"scpi:/dev/ttyUSB0,plate={path}{spec}", clock=VirtualClock())


def test_every_fault_of_a_file_is_told_with_its_line(file):
    edit(file, "amplitude_um_pp = 2.5", "amplitude_um_pp = -1\nspeed = 3")
    with pytest.raises(UserError) as caught:
        opened(file)
    for said in ("line ", "amplitude_um_pp", "speed"):
        assert said in str(caught.value)
