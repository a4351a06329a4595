import csv
import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.journals import mode_of
from slipscale.experiments.dataset.tsv import cell, sidecar
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.steps.columns import Column
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError
from slipscale.hardware.backends.mock import MockPlate
from tests.support.scripted import ScriptedParticipant
from tools.site.data_set_reference import WARNINGS

REPORT = 'it said "less" slippery;\tthen — collé, é'


def answers(step):
    question = step.question
    if isinstance(question, NumberQuestion):
        return 0.5
    if isinstance(question, YesNoQuestion):
        return True
    if isinstance(question, TextQuestion):
        return REPORT
    return question.options[-1][0]


@pytest.fixture
def dataset(laboratory, plan):
    for participant in ("01", "02"):
        laboratory.run(
            plan(participant=participant),
            person=lambda _: ScriptedParticipant(answers, laboratory.clock),
        )
    build_dataset(laboratory.folder)
    return laboratory.folder


def test_the_official_validator_finds_no_error(dataset):
    validator = Path(sys.executable).with_name("bids-validator-deno")
    done = subprocess.run(
        [validator, dataset, "--max-rows", "-1", "--format", "json"],
        capture_output=True,
        text=True,
        check=False,
    )
    issues = json.loads(done.stdout)["issues"]["issues"]
    assert [issue for issue in issues if issue["severity"] == "error"] == []
    assert done.returncode == 0
    # The page on the data set explains each remaining warning.
    assert {issue.get("subCode", issue["code"]) for issue in issues} == set(WARNINGS)


def test_events_have_the_times_of_the_table_s_trials_and_tags(dataset):
    for path in dataset.glob("sub-*/beh/*_events.tsv"):
        events = pd.read_csv(path, sep="\t")
        trials = pd.read_csv(path.with_name(path.name.replace("_events", "_beh")), sep="\t")
        assert list(events.columns[:4]) == ["onset", "duration", "trial_type", "trial"]
        assert not {"onset", "duration"} & set(trials.columns)
        assert events["trial"].tolist() == trials["trial"].tolist()
        assert events["trial_type"].tolist() == trials["phase"].tolist()
        assert events["surface"].tolist() == trials["surface"].tolist()
        assert (events["onset"].diff().dropna() > 0).all()
        assert (events["duration"] > 0).all()
        ends = (events["onset"] + events["duration"]).tolist()
        assert all(
            end <= later + 1e-5 for end, later in zip(ends, events["onset"][1:], strict=False)
        )
        task = path.name.split("_task-")[1].split("_")[0]
        told = json.loads((dataset / f"task-{task}_events.json").read_text(encoding="utf-8"))
        assert {k for k, v in told.items() if isinstance(v, dict)} == set(events.columns)
        assert set(told["trial_type"]["HED"]) == set(told["trial_type"]["Levels"])


def test_pybids_reads_tables_and_events(dataset):
    bids = pytest.importorskip("bids", reason="pybids is no test requirement")
    layout = bids.BIDSLayout(dataset, validate=True)
    assert sorted(layout.get_subjects()) == ["01", "02"]
    assert sorted(layout.get_tasks()) == ["descendingdifference", "magnitudeestimation"]
    for table, events in zip(
        *(layout.get(suffix=each, extension=".tsv") for each in ("beh", "events")), strict=True
    ):
        assert list(events.get_df()["trial"]) == list(table.get_df()["trial"])
        assert events.get_metadata()["onset"]["Units"] == "s"


@pytest.mark.skipif(not shutil.which("Rscript"), reason="R is not installed")
def test_r_reads_a_table_with_the_types_that_the_sidecar_describes(dataset):
    (table,) = dataset.glob("sub-01/beh/*_task-magnitudeestimation_run-01_beh.tsv")
    code = (
        f"d <- read.delim('{table.as_posix()}', na.strings = 'n/a'); "
        "cat(class(d$estimate), class(d$amplitude_um_pp), class(d$surface), nrow(d))"
    )
    done = subprocess.run(["Rscript", "-e", code], capture_output=True, text=True, check=True)
    rows = len(pd.read_csv(table, sep="\t"))
    assert done.stdout.split() == ["numeric", "numeric", "character", str(rows)]


def said_of(folder):
    name = json.loads((folder / "dataset_description.json").read_text(encoding="utf-8"))["Name"]
    return name.rpartition(" (")[2], (folder / "README.md").read_text(encoding="utf-8")


def test_a_person_who_answers_on_the_mock_is_not_called_simulated(dataset):
    name, readme = said_of(dataset)
    assert name == "pilot)"
    assert "answers come from people" in readme
    assert "imulated" not in readme
    levels = json.loads((dataset / "participants.json").read_text(encoding="utf-8"))["mode"]
    assert "a person who tried out the study" in levels["Levels"]["pilot"]


def test_simulated_participants_are_called_so(laboratory):
    laboratory.run()
    build_dataset(laboratory.folder)
    name, readme = said_of(laboratory.folder)
    assert name == "simulated pilot)"
    description = json.loads((laboratory.folder / "dataset_description.json").read_text("utf-8"))
    assert description["Authors"] == ["simulated by Slipscale"]
    assert "**Simulated.** No person took part" in readme


def test_every_column_is_described_and_every_description_is_a_column(dataset):
    for table in dataset.glob("sub-*/beh/*_beh.tsv"):
        task = table.name.split("_task-")[1].split("_")[0]
        described = json.loads((dataset / f"task-{task}_beh.json").read_text(encoding="utf-8"))
        described = {k for k, v in described.items() if isinstance(v, dict)}
        assert set(pd.read_csv(table, sep="\t").columns) == described


def test_free_text_with_quotes_tabs_and_accents_stays_in_its_cell(dataset):
    table = dataset / "sub-01/beh/sub-01_task-descendingdifference_run-01_beh.tsv"
    said = pd.read_csv(table, sep="\t")["verbal_report"]
    assert set(said) == {" ".join(REPORT.split())}
    with table.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream, delimiter="\t"))
    assert {len(row) for row in rows} == {len(rows[0])}


def test_sidecars_carry_what_the_numbers_depend_on(dataset):
    sidecar = dataset / "sub-02/beh/sub-02_task-magnitudeestimation_run-01_beh.json"
    notes = json.loads(sidecar.read_text(encoding="utf-8"))["Slipscale"]
    assert (notes["seed"], notes["mode"], notes["study"]) == (2007, "pilot", "biet2007")
    assert len(notes["study_hash"]) == 64
    assert notes["plate"]["backend"] == "mock"
    assert set(notes["software"]) == {"python", "slipscale", "numpy", "psychopy"}


def test_rebuilding_changes_nothing(dataset):
    before = {p: p.read_bytes() for p in dataset.rglob("*") if p.is_file()}
    build_dataset(dataset)
    assert {p: p.read_bytes() for p in dataset.rglob("*") if p.is_file()} == before


def test_the_readme_is_the_laboratorys_own_once_written(dataset):
    (dataset / "README.md").write_text("Ours.")
    build_dataset(dataset)
    assert (dataset / "README.md").read_text() == "Ours."


def test_an_interrupted_run_keeps_its_finished_trials_and_says_so(laboratory, plan):
    laboratory.run()
    path = plan().journal_path(laboratory.folder)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:60]))
    build_dataset(laboratory.folder)
    people = pd.read_csv(laboratory.folder / "participants.tsv", sep="\t")
    assert list(people["complete"]) == ["no"]
    table = laboratory.folder / "sub-01/beh/sub-01_task-descendingdifference_run-01_beh.tsv"
    assert len(pd.read_csv(table, sep="\t")) == 4


def test_pilots_and_participants_are_never_mixed(laboratory, plan):
    laboratory.run(plan(participant="01"))
    laboratory.run(plan(participant="02", mode="participant"))
    with pytest.raises(UserError, match="must not be mixed"):
        mode_of(laboratory.folder)


def test_missing_is_n_a_and_empty_text_is_missing():
    assert cell(None) == "n/a"
    assert cell("  ") == "n/a"
    assert cell(1e-9, "s") == "0"


SMALL_LEVELS = """
name = "small"
title = "Displacements in m"
displacements_m_pp = [0.0, 5e-7, 1.2e-6, 2.3e-6]

[quantity]
name = "displacement"
unit = "m"
convention = "peak to peak"

[plate]
displacement_m_pp = 2.5e-6

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0
"""


def test_levels_in_a_small_unit_reach_the_table_unchanged(laboratory, plan):
    trials = plan(SMALL_LEVELS)
    laboratory.run(trials)
    build_dataset(laboratory.folder)
    table = laboratory.folder / "sub-01/beh/sub-01_task-magnitudeestimation_run-01_beh.tsv"
    frame = pd.read_csv(table, sep="\t")
    assert sorted(frame["displacement_m_pp"]) == [0, 5e-7, 1.2e-6, 2.3e-6]
    presented = [
        record.data["answer"]["readback_level"]
        for record in laboratory.records(trials, "done")
        if record.data["answer"] and record.data["answer"]["type"] == "Presented"
    ]
    assert list(frame["displacement_readback_m_pp"]) == pytest.approx(presented, rel=1e-8)


@pytest.mark.parametrize("value", [1e-7, 0.009999999999, 0.01234567891, 0.1234567891, 1234.5678915])
def test_no_number_is_changed_by_more_than_a_ten_thousandth(value):
    assert float(cell(value)) == pytest.approx(value, rel=5e-5)
    assert "e" not in cell(value)


def test_a_damaged_journal_does_not_keep_the_next_participant_waiting(laboratory, plan):
    laboratory.run()
    path = plan().journal_path(laboratory.folder)
    path.write_bytes(path.read_bytes().replace(b'"end"', b'"and"'))
    assert mode_of(laboratory.folder) == "pilot"
    (problem,) = build_dataset(laboratory.folder)
    assert problem.file == "sourcedata/sub-01/sub-01_run-01_journal.jsonl"
    assert problem.what == "damaged: the checksum does not match"


def test_sessions_have_a_table_of_their_own(laboratory, plan, record_runs):
    text = study_text("biet2007").replace("seed = 2007", 'seed = 2007\nsessions = ["01", "02"]')
    for session in ("01", "02"):
        record_runs(laboratory.folder, "01", study_text=text, session=session, mode="participant")
    build_dataset(laboratory.folder)
    path = laboratory.folder / "sub-01/sub-01_sessions.tsv"
    table = pd.read_csv(path, sep="\t")
    assert list(table["session_id"]) == ["ses-01", "ses-02"]
    assert list(table["complete"]) == ["yes", "yes"]
    assert table["acq_time"].str.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ").all()
    described = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
    assert set(described) == set(table.columns) - {"session_id"}
    assert verify(laboratory.folder) == []
    validator = Path(sys.executable).with_name("bids-validator-deno")
    done = subprocess.run([validator, laboratory.folder], capture_output=True, check=False)
    assert done.returncode == 0, done.stdout


def test_without_sessions_there_is_no_such_table(dataset):
    assert not list(dataset.rglob("*_sessions.tsv"))


@pytest.mark.parametrize("study", ["biet2007", "matching"])
@pytest.mark.parametrize("kind", ["commanded", "measured"])
def test_a_level_that_the_plate_only_repeats_is_no_readback(
    laboratory, plan, monkeypatch, study, kind
):
    measure = MockPlate._measure
    monkeypatch.setattr(MockPlate, "_measure", lambda self: replace(measure(self), kind=kind))
    laboratory.run(plan(study_text(study), study_name=study))
    build_dataset(laboratory.folder)
    (path, *_) = laboratory.folder.glob("sub-01/beh/*ma*_beh.tsv")
    frame = pd.read_csv(path, sep="\t")
    readbacks = frame[[name for name in frame if "readback" in name]]
    expected = {"biet2007": "amplitude_readback_um_pp", "matching": "matched_readback_um_pp"}
    assert expected[study] in readbacks
    assert readbacks.isna().to_numpy().all() == (kind == "commanded")


def test_a_level_that_a_spreadsheet_would_run_is_text_in_table_and_sidecar():
    option = "@SUM(1+1)*cmd|' /C calc'!A0"
    column = Column(description="an answer", levels={option: "an option"})
    assert cell(option) == f"'{option}"
    assert sidecar({"answer": column})["answer"]["Levels"] == {cell(option): "an option"}
