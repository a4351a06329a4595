"""Studies whose levels are times or lengths: only levels are read as levels."""

import re

import pandas as pd
import pytest

from slipscale.analysis.pipeline import analyse
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.running.pilot import pilot_plans, run_pilot

COMMON = """
name = "{name}"
title = "Levels that resemble other columns"
language = "en"
seed = 3
participants = 3
attribute = "roughness"
"""
FACTOR = """
[[factors]]
name = "{factor}"
levels = ["one", "other"]
description = "A condition whose name ends in the unit of the levels"

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 2
"""
IN_S = f"""{COMMON.format(name="times")}
vary = "transition_s"
transition_times_s = [0.005, 0.02, 0.08, 0.3]

[stimulus]
kind = "transient"
from_um_pp = 0.4
to_um_pp = 1.2
position_mm = 10.0

[plate]
position = "lasers:/dev/ttyUSB0"
{FACTOR.format(factor="onset_s")}"""
IN_MM = f"""{COMMON.format(name="lengths")}
gaps_mm = [0.5, 1.0, 2.0]

[quantity]
name = "gap"
unit = "mm"
convention = ""

[plate]
gap_mm = 3.0
position = "mouse:mm_per_pixel=0.25"
{FACTOR.format(factor="offset_mm")}
[[tasks]]
protocol = "pointing"
distances_mm = [20.0, 40.0]
widths_mm = [4.0]
movements = 4
feedback = ["none", "target"]
ground_mm = 2.0
target_mm = 0.5

[[tasks]]
protocol = "magnitude_production"
standard_mm = 1.0
lowest_mm = 0.2
highest_mm = 2.4
step_mm = 0.1
modulus = 10.0
numbers = [7.0, 14.0]
repetitions = 2
"""


@pytest.fixture(scope="module", params=[IN_S, IN_MM], ids=["s", "mm"])
def piloted(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("levels")
    (folder / "study.toml").write_text(request.param)
    run_pilot(
        folder / "data",
        pilot_plans(str(folder / "study.toml"), participants=None, seed=1, language=None),
        tell=lambda _: 0,
    )
    build_dataset(folder / "data")
    return folder / "data", request.param is IN_S


def rows(folder, task, suffix="beh"):
    paths = sorted(folder.glob(f"sub-*/beh/*_task-{task}_run-01_{suffix}.tsv"))
    return pd.concat([pd.read_csv(path, sep="\t") for path in paths])


def test_tables_contain_the_levels_of_the_study_and_other_columns_are_untouched(piloted):
    folder, in_s = piloted
    table = rows(folder, "magnitudeestimation")
    column, factor = ("transition_time_s", "onset_s") if in_s else ("gap_mm", "offset_mm")
    levels = [0.005, 0.02, 0.08, 0.3] if in_s else [0.5, 1.0, 2.0]
    assert sorted(set(table[column])) == levels
    assert set(table[factor]) == {"one", "other"}
    assert (rows(folder, "magnitudeestimation", "events")["onset"].diff().dropna() != 0).all()
    assert table["response_time"].between(0.1, 60).all()
    if in_s:
        assert (table["changes"] >= 1).mean() > 0.9  # amplitude changes during the exploration
    else:
        movements = rows(folder, "pointing")
        assert set(movements["gap_mm"]) == {2.0}
        assert set(movements["distance_mm"]) == {20.0, 40.0}
        assert set(movements["width_mm"]) == {4.0}
        assert set(movements["target_x_mm"].abs()) == {10.0, 20.0}


def test_the_analysis_has_the_levels_of_the_study(piloted):
    folder, in_s = piloted
    found = analyse(folder)
    assert list(found.cells.columns) == ([0.005, 0.02, 0.08, 0.3] if in_s else [0.5, 1.0, 2.0])
    assert len(found.cells) == 3
    assert found.dataset.quantity.unit == ("s" if in_s else "mm")


def test_a_journal_is_read_as_it_was_written(piloted):
    folder, in_s = piloted
    path = folder / "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    assert not re.search(r'"\w+_level"', path.read_text())  # names in files have a unit
    records = read_plan(path)[1]
    factor = "onset_s" if in_s else "offset_mm"
    trials = [r.data["what"]["trial"] for r in records if r.kind == "begin"]
    trials = [each for each in trials if each and each["task"] == "magnitudeestimation"]
    assert {each["factors"][factor] for each in trials} == {"one", "other"}
    contact = [record.data for record in records if record.kind == "contact"]
    assert contact
    for each in contact:
        assert {"begun_s", "times_s"} <= set(each)
        assert not [name for name in each if name.endswith("_level")]
