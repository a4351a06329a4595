"""Studies in volts and in m/s²: from the file to the report, in their own unit."""

import json
import re

import pandas as pd
import pytest

from slipscale import commands
from slipscale.analysis.export.files import FORMS
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.tasks.thresholds.reading import COMPARISON, told_choices
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError
from slipscale.stimuli.level_names import NAMES
from slipscale.stimuli.quantity import PLATE_AMPLITUDE, made_by_plate

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
voltage_v_peak = 170.0
tolerance = 0.01
tolerance_v_peak = 0.5

[[tasks]]
protocol = "descending_difference"

[[tasks]]
protocol = "magnitude_estimation"
"""
#: A task of every other kind, as short as its analysis allows; numbers are multiples of a unit.
OTHERS = """
[[tasks]]
protocol = "matching"
repetitions = 1
practice = 0
catch_trials = 1
step_{suffix} = {1}
nearest_start_{suffix} = {10}
furthest_start_{suffix} = {20}
lowest_{suffix} = {0}
highest_{suffix} = {150}

[[tasks]]
protocol = "difference_threshold"
practice = 0
catch_trials = 1
standard_{suffix} = {60}
start_{suffix} = {20}
lowest_{suffix} = {1}
highest_{suffix} = {60}
steps_up = [0.2]
tracks = 1
most_trials = 12

[[tasks]]
protocol = "constant_stimuli"
practice = 0
catch_trials = 0
standard_{suffix} = {60}
comparisons_{suffix} = [{30}, {50}, {70}, {90}]
question = "yes_no"
repetitions = 4

[[tasks]]
protocol = "magnitude_production"
practice = 0
standard_{suffix} = {60}
modulus = 10.0
numbers = [8.0, 14.0]
repetitions = 1
step_{suffix} = {5}
lowest_{suffix} = {5}
highest_{suffix} = {150}
catch_trials = 1

[[tasks]]
protocol = "ratio_to_standard"
practice = 0
standard_{suffix} = {60}
repetitions = 1
catch_trials = 1

[[tasks]]
protocol = "visual_analogue_scale"
practice = 0
repetitions = 2
catch_trials = 1

[[tasks]]
protocol = "paired_comparison"
practice = 0
repetitions = 2
catch_trials = 0
"""


def of_every_kind(head, suffix, unit):
    """Return a study with every kind of task, whose levels are multiples of ``unit``."""
    tasks = OTHERS.replace("{suffix}", suffix)
    return head + re.sub(r"\{(\d+)\}", lambda found: f"{int(found[1]) * unit:g}", tasks)


EVERY_KIND = {
    "volts": of_every_kind(VOLTS.replace("[0.0, 40.0, 120.0]", "[40.0, 80.0, 120.0]"), "v_peak", 1),
    "accelerations": of_every_kind(
        VOLTS.replace("voltages_v_peak = [0.0, 40.0, 120.0]", "accelerations_m_s2_rms = [4, 8, 12]")
        .replace('"voltage"\nunit = "V"', '"acceleration"\nunit = "m/s²"')
        .replace('"peak"', '"RMS"\njudged = "intensity"')
        .replace("voltage_v_peak = 170.0", "acceleration_m_s2_rms = 17.0")
        .replace("tolerance_v_peak = 0.5", "tolerance_m_s2_rms = 0.05"),
        "m_s2_rms",
        0.1,
    ),
}
FOREIGN = re.compile("µm|um_pp|mplitude")


@pytest.mark.usefixtures("figures_and_models_left_out")
@pytest.mark.parametrize("study", EVERY_KIND.values(), ids=EVERY_KIND)
def test_every_kind_of_task_is_written_in_the_studys_quantity_alone(
    study, tmp_path, capsys, monkeypatch
):
    made = []
    monkeypatch.setattr(
        "slipscale.analysis.pipeline.analyse", lambda data: made.append(analyse(data)) or made[0]
    )
    (tmp_path / "study.toml").write_text(study, "utf-8")
    out = tmp_path / "out"
    pilot = ["pilot", str(tmp_path / "study.toml"), "--participants", "3", "--out", str(out)]
    assert commands.main(pilot) == 0
    for form in ("scripts", "methods"):
        FORMS[form](made[0], out / "derivatives" / "slipscale" / "report.html")
    told = capsys.readouterr()
    assert not FOREIGN.search(told.out + told.err)
    texts = {
        path: path.read_text("utf-8")
        for path in out.rglob("*")
        if path.is_file() and path.suffix != ".png"
    }
    assert {path.name: FOREIGN.findall(text) for path, text in texts.items()} == {
        path.name: [] for path in texts
    }
    found = json.loads(texts[out / "derivatives" / "slipscale" / "inference.json"])
    kinds = ("difference", "thresholds", "scales", "matching", "ratings", "ratios", "productions")
    assert [kind for kind in kinds if not isinstance(found[kind], list | dict)] == []
    assert [kind for kind in kinds if "reason" in found[kind]] == []


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
    assert sorted(found.estimates["level"].unique()) == [0, 40, 120]


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("voltages_v_peak", "amplitudes_um_pp", "amplitudes_um_pp: unknown key"),
        ("voltages_v_peak", "levels", "levels: unknown key"),
        ("voltages_v_peak", "voltages_v_peek", r"did you mean 'voltages_v_peak'"),
        ("120.0]", "180.0]", "180.0 is beyond the plate's 170.0 V peak"),
        (
            "voltage_v_peak = 170.0\n",
            "",
            "plate.voltage_v_peak: is missing; expected a value in V peak",
        ),
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


@pytest.mark.parametrize(
    "quantity", [PLATE_AMPLITUDE, made_by_plate("voltage", "V", "peak")], ids=["um", "volts"]
)
def test_every_name_in_the_code_has_one_name_in_a_file_and_back(quantity):
    parts = {"interval": "interval2_", "when": "_before", "end": "", "what": "standard"}
    for pattern, _ in NAMES:
        name = pattern.format(**parts, several="comparison")
        assert quantity.in_code[quantity.in_file[name]] == name
    assert quantity.named("level_readback") == quantity.column.replace("_", "_readback_", 1)


def test_differences_far_below_one_are_told_apart():
    frame = pd.DataFrame(
        {
            "task": "comparing",
            "track_level": [1.2e-4, 1.3e-4],
            "standard_level": 1e-4,
            "comparison_more": "true",
            "response": ["1", "2"],
        }
    )
    found = told_choices(frame, COMPARISON, made_by_plate("force", "N", ""))
    assert found["track_level"].tolist() == [2e-5, 3e-5]
