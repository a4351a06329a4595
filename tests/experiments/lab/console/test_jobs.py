"""What the console starts goes on without it."""

import pytest

from slipscale.experiments.lab.console import jobs as job_file
from slipscale.experiments.lab.console.jobs import Jobs
from slipscale.experiments.lab.console.page_texts import Words
from slipscale.experiments.lab.console.state import findings
from slipscale.faults import UserError


@pytest.fixture(autouse=True)
def _as_urgent_as_others(monkeypatch):
    """On a busy machine, a job of the lowest priority could wait for minutes."""
    monkeypatch.setattr(job_file, "LEAST_URGENT", 0)


def test_a_job_tells_its_status_and_its_last_complaint(lab):
    jobs = Jobs(lab)
    job = jobs.start("analysis", "the analysis", "analyse", "nothing")
    job.process.wait()
    assert (job.status, jobs.last("analysis")) == (2, job)
    assert "nothing: no such file or folder" in job.complained()
    assert "nothing : ce fichier ou dossier" in Words("fr").say(job.complained()).replace(
        "\xa0", " "
    )


def test_one_of_a_kind_runs_at_a_time(lab, monkeypatch):
    jobs = Jobs(lab)
    job = jobs.start("check", "the checklist", "--help")
    job.process.wait()
    assert "usage: slipscale" in job.said()

    monkeypatch.setattr(job.process, "poll", lambda: None)
    with pytest.raises(UserError, match="the checklist: still running"):
        jobs.start("check", "the checklist", "--help")


def test_a_folder_that_has_gone_is_told(tmp_path):
    with pytest.raises(UserError, match="is the folder still there"):
        Jobs(tmp_path / "gone").start("check", "the checklist", "check")


@pytest.mark.parametrize("text", ["", "rubbish", "{}", "[1"])
def test_a_checklist_that_cannot_be_read_is_none(text):
    assert findings(text) is None
