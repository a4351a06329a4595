"""Magnitude estimation and descending difference under labels of a study's own."""

import pytest

from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.commands import main
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.faults import UserError
from tests.support.board_sessions import STUDY

pytestmark = pytest.mark.usefixtures("without_models")

LABELLED = STUDY.replace("[[tasks]]", '[[tasks]]\nlabel = "slipperiness"')
AGAIN = LABELLED.partition("[[tasks]]")[2].replace("slipperiness", "roughness")
STEPS = """
[[tasks]]
protocol = "descending_difference"
label = "steps"
"""


def pilot(folder, text):
    """Run a study with two simulated people; return its data set."""
    (folder / "study.toml").write_text(text)
    plans = pilot_plans(str(folder / "study.toml"), participants=2, seed=1, language=None)
    run_pilot(folder / "data", plans, tell=lambda _: None)
    return folder / "data"


@pytest.fixture(scope="module")
def twice(tmp_path_factory):
    return pilot(tmp_path_factory.mktemp("twice"), f"{LABELLED}\n[[tasks]]{AGAIN}{STEPS}")


def test_a_task_with_a_label_is_analysed_as_one_without(tmp_path):
    data = load(pilot(tmp_path, LABELLED))
    assert data.counts["analysed"] == 2 * 3
    assert not [each for each in data.problems if "label" in each]
    assert analyse(data).table3 is not None


def test_of_several_labels_one_is_analysed_and_the_rest_is_told(twice):
    data = load(twice)
    assert (data.counts["analysed"], len(data.differences) > 0) == (2 * 3, True)
    [told] = [each for each in data.problems if "several labels" in each]
    assert "only 'roughness' is analysed, not 'slipperiness'" in told
    assert not data.others


def test_a_label_names_which(twice):
    first, second = load(twice), load(twice, task="slipperiness")
    assert first.estimates["estimate"].tolist() != second.estimates["estimate"].tolist()
    assert len(second.differences) == len(first.differences)
    assert "'slipperiness' is analysed" in " ".join(second.problems)


def test_a_label_that_is_not_there_is_told_with_those_that_are(twice):
    with pytest.raises(UserError, match="expected roughness or slipperiness or steps"):
        load(twice, task="grip")


def test_the_results_of_one_label_lie_in_a_folder_of_their_own(twice):
    assert main(["analyse", str(twice), "--task", "slipperiness"]) == 0
    assert (twice / "derivatives/slipscale/task-slipperiness/report.html").is_file()
