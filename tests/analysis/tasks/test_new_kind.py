"""A kind of task that does nothing but exist is shown in every place that should show it."""

import json
import sys

import pandas as pd
import pytest
from matplotlib.figure import Figure

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.labelled_tasks import TaskTrials, read_main_trials
from slipscale.analysis.reporting import files
from slipscale.analysis.reporting.sections.summary import answers
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Family, Statistic
from slipscale.analysis.tasks import table
from slipscale.analysis.tasks.kind import TaskAnalysis
from slipscale.analysis.writing import html
from slipscale.faults import UserError

COLUMNS = ("participant_id", "session", "run", "task", "trial", "weight")


def read(entries, folder, problems, counts):
    if not entries:
        return empty(), []
    return read_main_trials(
        entries,
        folder,
        kind="weight",
        required=("weight",),
        columns=("trial", "weight"),
        problems=problems,
        counts=counts,
    )


def empty():
    return pd.DataFrame(columns=list(COLUMNS))


TRIALS = TaskTrials(
    name="weights",
    counted="weight",
    title="weighing",
    belongs=lambda header: "weight" in header,
    read=read,
    empty=empty,
)


class Weights(Statistic[object]):
    key = "weights"
    meaning = "whether weights differ"
    test = False
    families = (Family(name="weights, a test", read=lambda found: [found["p"]]),)

    def compute(self, inputs):
        rows = inputs.data.of(TRIALS)
        return {"p": 0.01, "n": len(rows)} if len(rows) else NotComputed("nothing was weighed")


class Weighing(TaskAnalysis):
    name = "weights"
    trials = TRIALS
    statistics = (Weights(),)

    def questions(self, _analysis):
        return ["Question of weights?"]

    def design(self, _analysis):
        return ["design of weights"]

    def answers(self, _analysis):
        return ["Answer of weights."]

    def doubts(self, _analysis):
        return ["Doubt of weights."]

    def sentences(self, _analysis):
        return {"Heading of weights": ["Sentence of weights."]}

    def sections(self, _analysis, svgs):
        found = html.ReportSection("Section of weights", shown="open")
        found.blocks.append(html.figure(svgs["weights"], "Figure of weights", "Weights"))
        return [found]

    def figures(self, _analysis):
        return {"weights": Figure()}

    def tables(self, analysis):
        return {"weights": analysis.dataset.of(TRIALS)[["task", "weight"]]}

    def session_tables(self, _data, _prepared):
        table = pd.DataFrame({"1": [1.0, 2, 4], "2": [2.0, 3, 3]})
        return [("measure of weights", "kg", table)]


KIND = Weighing()


@pytest.fixture
def with_kind(monkeypatch):
    """Add the kind to the table, wherever a module has taken it from there."""
    longer = {
        "KINDS": (*table.KINDS, KIND),
        "TRIALS": (*table.TRIALS, TRIALS),
    }
    for name, value in longer.items():
        ours = getattr(table, name)
        for module in [each for key, each in sys.modules.items() if "slipscale.analysis" in key]:
            if getattr(module, name, None) is ours:
                monkeypatch.setattr(module, name, value)


def write(folder, sessions, phase="main"):
    (folder / "dataset_description.json").write_text('{"Name": "W", "BIDSVersion": "1.10.0"}')
    for who in ("01", "02", "03"):
        for session in sessions:
            path = folder / f"sub-{who}/ses-{session}/beh"
            path.mkdir(parents=True)
            name = f"sub-{who}_ses-{session}_task-mine_run-01_beh"
            (path / f"{name}.tsv").write_text(f"trial\tphase\tweight\tflag\n1\t{phase}\t5\tn/a\n")
            (path / f"{name}.json").write_text('{"mode": "participant"}')
    return folder


@pytest.mark.usefixtures("with_kind")
def test_every_part_of_a_kind_is_shown(tmp_path):
    analysis = analyse(write(tmp_path, ("1", "2")))
    out = tmp_path / "out"
    report = files.write_analysis(analysis, out).read_text(encoding="utf-8")
    for part in ("Question", "design", "Answer", "Doubt", "Heading", "Sentence", "Section"):
        assert f"{part} of weights" in report
    assert "Figure of weights" in report
    assert "measure of weights" in report  # sessions are compared
    assert "Weights, a test" in report  # among all tests
    assert answers(analysis) == ["Answer of weights."]  # what a terminal prints
    assert json.loads((out / "inference.json").read_text())["weights"] == {"p": 0.01, "n": 6}
    assert pd.read_csv(out / "weights.csv")["weight"].tolist() == [5] * 6
    assert (out / "weights.svg").is_file()


@pytest.mark.usefixtures("with_kind")
def test_a_task_of_the_kind_is_read_by_its_columns_and_not_among_others(tmp_path):
    data = load(write(tmp_path, ("1",)))
    assert len(data.of(TRIALS)) == 3
    assert data.others == {}
    assert data.people == {"sub-01", "sub-02", "sub-03"}


@pytest.mark.usefixtures("with_kind")
def test_rows_that_leave_nothing_to_analyse_are_counted_under_the_kind(tmp_path):
    with pytest.raises(UserError, match="3 practice trials of weighing"):
        analyse(write(tmp_path, ("1",), phase="practice"))


def test_a_kind_that_is_not_in_the_table_is_not_shown(tmp_path):
    with pytest.raises(UserError, match="install a package that analyses them"):
        analyse(write(tmp_path, ("1",)))


def test_a_gist_of_letters_is_refused():
    with pytest.raises(UserError, match="section 'Weights': gist is a text, expected a list"):
        html.ReportSection("Weights", gist="One sentence.")
