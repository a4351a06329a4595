"""Studies in volts and in m/s²: from the file to the report, in their own unit."""

import json
import re

import pytest

from slipscale import commands
from slipscale.analysis.load import load
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError
from slipscale.stimuli.quantity import NAMES, in_code, in_um, made_by_plate

VOLTS = """
name = "electro"
title = "An electrovibrating plate"
participants = 3
voltages_v_peak = [0.0, 40.0, 120.0]

[quantity]
name = "voltage"
unit = "V"
convention = "peak"

[plate]
voltage_v_peak = 130.0

[[tasks]]
protocol = "descending_difference"

[[tasks]]
protocol = "magnitude_estimation"
"""
ACCELERATIONS = """
name = "button"
title = "A vibrating button"
participants = 3
accelerations_m_s2_peak = [4.0, 8.0, 16.0]

[quantity]
name = "acceleration"
unit = "m/s²"
convention = "peak"
judged = "intensity"

[plate]
acceleration_m_s2_peak = 32.0
tolerance = 0.01
tolerance_m_s2_peak = 0.2

[[tasks]]
protocol = "matching"
step_m_s2_peak = 0.5
nearest_start_m_s2_peak = 1.0
furthest_start_m_s2_peak = 3.0
lowest_m_s2_peak = 0.0
highest_m_s2_peak = 30.0

[[tasks]]
protocol = "magnitude_estimation"
"""
FOREIGN = re.compile("µm|um_pp|mplitude")


@pytest.fixture(params=[VOLTS, ACCELERATIONS], ids=["volts", "accelerations"])
def study_file(request, tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(request.param, "utf-8")
    return path


def test_a_pilot_and_its_report_are_in_the_studys_unit_alone(study_file, tmp_path, capsys):
    out = tmp_path / "out"
    assert commands.main(["pilot", str(study_file), "--seed", "3", "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert not FOREIGN.search(told.out + told.err)
    texts = {
        path: path.read_text("utf-8")
        for path in out.rglob("*")
        if path.suffix in {".tsv", ".json", ".jsonl", ".csv", ".html", ".svg", ".md", ".toml", ""}
        and path.is_file()
    }
    assert len(texts) > 20
    assert {
        str(p.name): FOREIGN.findall(text) for p, text in texts.items() if FOREIGN.search(text)
    } == {}
    report = texts[out / "derivatives" / "slipscale" / "report.html"]
    assert "voltage" in report or "acceleration" in report


def test_a_resumed_run_and_the_tables_of_its_journal_have_the_same_levels(tmp_path):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(VOLTS, "utf-8")
    pilot = ["pilot", str(study), "--participants", "2", "--out", str(out)]
    assert commands.main(pilot) == 0
    table = next(out.glob("sub-01/beh/*magnitudeestimation*_beh.tsv"))
    whole = table.read_bytes()
    assert b"\tvoltage_v_peak\tvoltage_readback_v_peak\t" in whole
    journal = next(out.glob("sourcedata/sub-01/*.jsonl"))
    lines = journal.read_bytes().splitlines(keepends=True)
    assert json.loads(lines[0])["quantity"]["unit"] == "V"
    journal.write_bytes(b"".join(lines[: len(lines) // 2]))
    assert commands.main(pilot) == 0
    assert table.read_bytes() == whole
    found = load(out)
    assert found.quantity == made_by_plate("voltage", "V", "peak")
    assert sorted(found.estimates["amplitude_um_pp"].unique()) == [0, 40, 120]


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("voltages_v_peak", "amplitudes_um_pp", "amplitudes_um_pp: unknown key"),
        ("voltages_v_peak", "levels", "levels: unknown key"),
        ("voltages_v_peak", "voltages_v_peek", r"did you mean 'voltages_v_peak'"),
        ("120.0]", "140.0]", "140.0 is beyond the plate's 130.0 V peak"),
        ("voltage_v_peak = 130.0\n", "", "plate.voltage_v_peak: is missing; its default is in µm"),
        (
            'protocol = "magnitude_estimation"',
            'protocol = "difference_threshold"\nstandard_v_peak = 40.0',
            "start_v_peak of item 2 of tasks: is missing",
        ),
        ('"peak"', '"largest"', "quantity.convention"),
    ],
)
def test_a_key_of_another_quantity_or_a_level_left_out_is_named(old, new, said):
    with pytest.raises(UserError, match=said):
        parse_study(VOLTS.replace(old, new, 1), "study.toml")


def test_a_study_in_volts_meets_no_plate_in_micrometres(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(VOLTS, "utf-8")
    assert commands.main(["plate", "new", "own.toml", "--backend", "mock"]) == 0
    for command in (
        ["pilot", "study.toml", "--plate", "mock:plate=own.toml"],
        ["check", "study.toml", "--plate", "mock:plate=own.toml", "--only", "plate"],
    ):
        assert commands.main(command) != 0
        told = capsys.readouterr()
        assert "makes amplitude in µm peak to peak" in told.out + told.err


def test_every_name_in_a_file_in_micrometres_has_one_name_in_the_code_and_back():
    names = [
        pattern.format(interval="interval2_", when="_before", what="standard")
        for pattern, _ in NAMES
    ]
    for name in (*names, "amplitude_um_pp", "amplitude_readback_um_pp"):
        assert "um" not in in_code(name)
        assert in_um(in_code(name)) == name
    volts = made_by_plate("voltage", "V", "peak to peak")
    assert volts.named("level_readback") == "voltage_readback_v_pp"
    assert volts.in_um("interval1_voltage_v_pp") == "interval1_amplitude_um_pp"
