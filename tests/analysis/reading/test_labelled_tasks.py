"""From a simulated study of seven tasks to what is read and reported of each."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reporting.files import write_analysis
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.faults import UserError
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

pytestmark = pytest.mark.usefixtures("without_simulated_fits")

STUDY = """
name = "thresholds"
title = "Thresholds"
language = "en"
seed = 5
participants = 2
amplitudes_um_pp = [0.0, 0.8, 1.0, 1.2, 1.3, 1.5, 1.7]

[plate]
tolerance = 0.01
tolerance_um_pp = 0.02  # four standard deviations of the mock's readings

[[tasks]]
protocol = "difference_threshold"
standard_um_pp = 1.2
intervals = 3
rule = "weighted"
start_um_pp = 0.4
lowest_um_pp = 0.02
highest_um_pp = 0.8
tracks = 2
most_trials = 12
practice = 2
catch_trials = 2

[[tasks]]
protocol = "detection_threshold"
rule = "quest_plus"
lowest_um_pp = 0.02
highest_um_pp = 1.2
tracks = 1
most_trials = 20
practice = 0
catch_trials = 0

[[tasks]]
protocol = "constant_stimuli"
label = "oneside"
standard_um_pp = 1.2
comparisons_um_pp = [1.3, 1.5, 1.7]
repetitions = 6
practice = 1
catch_trials = 1

[[tasks]]
protocol = "constant_stimuli"
label = "bothsides"
question = "yes_no"
standard_um_pp = 1.2
comparisons_um_pp = [0.8, 1.0, 1.5, 1.7]
repetitions = 6
practice = 1
catch_trials = 0

[[tasks]]
protocol = "paired_comparison"
label = "pairs"
repetitions = 1

[[tasks]]
protocol = "paired_comparison"
label = "triads"
form = "triads"
repetitions = 1

[[tasks]]
protocol = "matching"
references_um_pp = [1.2]
repetitions = 2
catch_trials = 1
reference_again = true
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("thresholds")
    study = where / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    plans = pilot_plans(str(study), participants=None, seed=None, language=None)
    run_pilot(where / "data", plans, tell=lambda _: None)
    return where / "data"


@pytest.fixture(scope="module")
def analysis(folder):
    return analyse(folder)


def test_every_answered_main_trial_is_read_with_how_it_was_asked(folder):
    rows = load(folder).trials["forced_choices"]
    methods = rows.groupby("task")["method"].unique().map(list).to_dict()
    assert methods == {
        "bothsides": ["comparison"],
        "detectionthreshold": ["two_interval"],
        "differencethreshold": ["three_interval"],
        "oneside": ["two_interval"],
    }
    counts = rows[~rows["catch"]].groupby(["task", "participant_id"], observed=True).size()
    assert counts["oneside"].tolist() == [18] * 2
    assert counts["bothsides"].tolist() == [24] * 2
    assert counts["detectionthreshold"].tolist() == [20] * 2
    # Read by hand from one table: differences where more is right, amplitudes where it is not.
    table = pd.read_csv(
        folder / "sub-01/beh/sub-01_task-oneside_run-01_beh.tsv", sep="\t", na_values="n/a"
    )
    table = table[(table["phase"] == "main") & ~table["catch"]]
    own = rows[(rows["task"] == "oneside") & (rows["participant_id"] == "sub-01") & ~rows["catch"]]
    assert own["track_level"].tolist() == pytest.approx((table["comparison_um_pp"] - 1.2).tolist())
    assert own["correct"].tolist() == table["comparison_more"].tolist()


def test_pairs_triads_and_matches_are_read_as_the_tables_have_them(folder, analysis):
    data = load(folder)
    assert data.trials["comparisons"].groupby("task")["stimulus3"].unique().map(
        len
    ).to_dict().keys() == {
        "pairs",
        "triads",
    }
    table = pd.read_csv(
        folder / "sub-02/beh/sub-02_task-matching_run-01_beh.tsv", sep="\t", na_values="n/a"
    )
    table = table[table["phase"] == "main"]
    own = data.trials["matches"][data.trials["matches"]["participant_id"] == "sub-02"]
    for name in ("matched_level", "catch", "felt_again"):
        assert own[name].tolist() == table[PLATE_AMPLITUDE.named(name)].tolist()
    assert own["catch"].sum() == 1
    assert set(own["reference_level"]) == {1.2}
    (matched,) = analysis.inference.matching
    assert (matched.reference_level, matched.participants) == (1.2, 2)
    assert (matched.matches, matched.catch_trials) == (8, 2)
    pairs, triads = analysis.inference.scales
    assert pairs.surfaces == triads.surfaces == ("0", "0.8", "1", "1.2", "1.3", "1.5", "1.7")
    assert sum(pairs.chosen) == pairs.answers


def test_rows_left_out_are_counted(folder):
    counts = load(folder).counts
    read = counts["choice_rows"]
    left_out = ("practice", "voided", "unanswered")
    assert read == counts["choice_analysed"] + sum(counts[f"choice_{name}"] for name in left_out)
    assert counts["choice_practice"] == 2 * 4


def test_each_task_has_its_thresholds_and_the_report_its_figures(analysis, tmp_path):
    found = analysis.inference.thresholds
    assert not isinstance(found, NotComputed)
    assert [task.task for task in found] == [
        "bothsides",
        "detectionthreshold",
        "differencethreshold",
        "oneside",
    ]
    assert [task.standard_level for task in found] == [1.2, None, 1.2, 1.2]
    report = write_analysis(analysis, tmp_path)
    page = report.read_text(encoding="utf-8")
    assert "Constant stimuli around 1.2 µm (bothsides)" in page
    assert "Detection threshold: " in page
    for task in found:
        assert (tmp_path / f"thresholds_{task.task}.svg").exists()
    for name in ("Paired comparison of 7 surfaces (pairs)", "Triads of 7 surfaces (triads)"):
        assert name in page
    assert {"scales.csv", "matching.csv", "matching_matching.svg"} <= {
        path.name for path in tmp_path.iterdir()
    }
    assert (tmp_path / "tracks_detectionthreshold.svg").exists()
    assert not (tmp_path / "tracks_oneside.svg").exists()
    table = pd.read_csv(tmp_path / "thresholds.csv")
    assert len(table) == 4 * 2
    written = json.loads((tmp_path / "inference.json").read_text(encoding="utf-8"))
    first = written["thresholds"][0]
    row = table[(table["task"] == first["task"]) & (table["participant_id"] == "sub-01")].iloc[0]
    assert row["trials"] == first["participants"][0]["trials"]


def test_answers_of_another_spelling_are_left_out_and_counted(folder, tmp_path):
    copied = Path(shutil.copytree(folder, tmp_path / "copy"))
    shutil.rmtree(copied / "sourcedata")
    path = copied / "sub-02/beh/sub-02_task-oneside_run-01_beh.tsv"
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[-1] = lines[-1].replace("\ttrue\t", "\tmaybe\t").replace("\tfalse\t", "\tmaybe\t")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    counts = load(copied).counts
    assert counts["choice_unanswered"] == 1


def test_a_study_of_practice_only_says_why_there_is_nothing(folder, tmp_path):
    copied = Path(shutil.copytree(folder, tmp_path / "copy"))
    shutil.rmtree(copied / "sourcedata")
    for path in copied.glob("sub-*/beh/*_beh.tsv"):
        text = path.read_text(encoding="utf-8").replace("\tmain\t", "\tpractice\t")
        path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match="practice trials of forced choice"):
        analyse(copied)
