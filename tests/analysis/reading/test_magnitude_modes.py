"""Studies on a line, against a standard and of production: from a pilot to tables and report."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.participants.simulated_people.population import Population, curves
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = pytest.mark.usefixtures("without_models")

STUDY = """
name = "modes"
title = "Modes"
language = "en"
seed = 5
participants = 3
amplitudes_um_pp = [0.5, 1.2, 2.0]

[[textures]]
name = "ridges"
spatial_period_mm = 5.0
mean_um_pp = 1.0
depth_um_pp = 0.5
finger_speed_mm_s = 50.0

[[tasks]]
protocol = "visual_analogue_scale"
label = "line"
repetitions = 2
practice = 1
catch_trials = 1
resolution = 5.0
key_step = 5.0

[[tasks]]
protocol = "ratio_to_standard"
label = "ratios"
standard_um_pp = 1.0
standard_every_trials = 2
repetitions = 1
practice = 0
catch_trials = 1

[[tasks]]
protocol = "magnitude_production"
label = "made"
standard_um_pp = 0.8
numbers = [7.0, 14.0]
repetitions = 1
practice = 0
step_um_pp = 0.2
catch_trials = 1
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("modes")
    study = where / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    plans = pilot_plans(str(study), participants=None, seed=None, language=None)
    run_pilot(where / "data", plans, tell=lambda _: None)
    return where / "data"


ALIKE = Population(
    sd_sensation=(0.4,) * 4, noise_sigma=0.0, line_shift_sd=0.0, line_stretch_sigma=0.0
)


def test_people_who_feel_alike_are_found_as_they_feel(tmp_path):
    """Their one curve is the population's mean: what each task should find is read from it."""
    study = tmp_path / "study.toml"
    study.write_text(STUDY.replace("step_um_pp = 0.2", "step_um_pp = 0.02"), encoding="utf-8")
    plans = pilot_plans(str(study), participants=None, seed=None, language=None, population=ALIKE)
    run_pilot(tmp_path / "data", plans, tell=lambda _: None)
    felt = curves(ALIKE).mean
    found = analyse(tmp_path / "data").inference
    (rated,), (judged,), (made,) = found.ratings, found.ratios, found.productions
    for each in rated.surfaces[:3]:
        assert each.mean == pytest.approx(felt(float(each.surface)), abs=2.5)  # places of 5
    for each in judged.surfaces:
        assert each.ratio == pytest.approx(felt(each.comparison_level) / felt(1.0), rel=0.05)
    assert judged.catch_ratio == pytest.approx(1.0, rel=0.03)
    plain = [each.comparison_level for each in judged.surfaces]
    expected = np.polyfit(np.log(plain), np.log([felt(each) for each in plain]), 1)[0]
    assert judged.power_law.exponent == pytest.approx(expected, abs=0.04)
    for each in made.numbers:
        assert felt(each.level) == pytest.approx(each.number / 10 * felt(0.8), rel=0.04)


@pytest.fixture(scope="module")
def analysis(folder):
    return analyse(folder)


def table(folder, task, participant="01"):
    path = folder / f"sub-{participant}/beh/sub-{participant}_task-{task}_run-01_beh.tsv"
    rows = pd.read_csv(path, sep="\t", na_values="n/a")
    return rows[rows["phase"] == "main"]


def test_main_trials_are_read_as_the_tables_have_them(folder):
    data = load(folder)
    for rows, task, column in (
        (data.trials["ratings"], "line", "rating"),
        (data.trials["ratios"], "ratios", "ratio"),
        (data.trials["productions"], "made", "produced_level"),
    ):
        written = table(folder, task)
        own = rows[rows["participant_id"] == "sub-01"]
        assert own[column].tolist() == written[PLATE_AMPLITUDE.named(column)].tolist()
        assert own["catch"].tolist() == written["catch"].tolist()
        assert own["catch"].sum() == 1
    assert set(data.trials["ratings"]["surface"]) == {"0", "0.5", "1.2", "2", "ridges"}
    assert (data.trials["ratings"]["rating"] % 5 == 0).all()
    texture = data.trials["ratings"]["surface"] == "ridges"
    assert data.trials["ratings"]["level"].isna().tolist() == texture.tolist()
    assert not len(data.estimates)
    assert data.people == {"sub-01", "sub-02", "sub-03"}


def test_rows_left_out_are_counted(folder):
    counts = load(folder).counts
    for kind, practice in (("rating", 12), ("ratio", 0), ("production", 0)):
        assert counts[f"{kind}_practice"] == practice
        left_out = sum(counts[f"{kind}_{name}"] for name in ("practice", "voided", "unanswered"))
        assert counts[f"{kind}_rows"] == counts[f"{kind}_analysed"] + left_out


def test_each_task_is_in_every_output(analysis, tmp_path):
    page = write_analysis(analysis, tmp_path).read_text(encoding="utf-8")
    written = json.loads((tmp_path / "inference.json").read_text(encoding="utf-8"))
    assert [task["task"] for task in written["ratings"]] == ["line"]
    assert written["ratings"][0]["resolution"] == 5
    assert written["ratios"][0]["standard_um_pp"] == 1.0
    assert written["productions"][0]["both"]["counterpart"] == "ratio judgements"
    for name in ("ratings", "ratios", "productions"):
        rows = pd.read_csv(tmp_path / f"{name}.csv")
        part = {"ratings": "surfaces", "ratios": "surfaces", "productions": "numbers"}[name]
        assert len(rows) == len(written[name][0][part])
    for figure in ("ratings_line", "ratios_ratios", "productions_made"):
        assert (tmp_path / f"{figure}.svg").exists()
    for said in (
        "Visual analogue scale (line), 24 ratings by 3 participants",
        "ratios and exponents are not meaningful",
        "Ratio judgements against 1 µm (ratios), 9 judgements by 3 participants",
        "Magnitude production (made), 12 productions by 3 participants",
        "For the 3 participants who did both tasks, the exponent of production",
    ):
        assert said in page.replace("\N{NO-BREAK SPACE}", " ")


def test_a_test_that_the_study_did_not_choose_is_not_made(folder):
    data = load(folder)
    few = data.choices.model_copy(update={"tests": ("ratios",)})
    found = analyse(replace(data, choices=few)).inference
    assert isinstance(found.ratings, NotComputed)
    assert isinstance(found.productions, NotComputed)
    assert not isinstance(found.ratios, NotComputed)


BAD = {
    "above the line": ("line", "rating", "120", "ratings are above the maximum (100,"),
    "below the line": ("line", "rating", "-3", "'-3' instead of a number of 0 or more"),
    "no ratio": ("ratios", "ratio", "0", "1 ratios are 0; they cannot form a ratio"),
    "no amplitude": (
        "made",
        "produced_um_pp",
        "0",
        "1 productions are 0; they cannot form a ratio",
    ),
    "no number": ("made", "produced_um_pp", "much", "'much' instead of a number"),
}


@pytest.mark.parametrize("case", BAD)
def test_an_answer_that_cannot_be_is_named_and_left_out(folder, tmp_path, case):
    task, column, value, said = BAD[case]
    target = tmp_path / "sub-01" / "beh"
    target.mkdir(parents=True)
    name = f"sub-01_task-{task}_run-01_beh.tsv"
    rows = pd.read_csv(folder / "sub-01" / "beh" / name, sep="\t", dtype=str, na_filter=False)
    rows.loc[rows.index[-1], column] = value
    rows.to_csv(target / name, sep="\t", index=False)
    data = load(tmp_path)
    assert any(said in problem for problem in data.problems)
    (kept,) = (
        len(each)
        for each in (data.trials["ratings"], data.trials["ratios"], data.trials["productions"])
        if len(each)
    )
    assert kept == (rows["phase"] == "main").sum() - 1
