"""Results that grow by themselves, once they may be seen, and the analysis at work."""

import json
import os
import re
import sys
from types import SimpleNamespace
from typing import get_args

import pytest

from slipscale.commands import main
from slipscale.experiments.lab.console.jobs import Job, Jobs
from slipscale.experiments.lab.console.page_texts import page_texts
from slipscale.experiments.lab.roster import read_roster
from slipscale.experiments.study.analysis_choices import QualityFlag
from slipscale.experiments.study.file import parse_study, study_text

LATER_S = 60.0
ANALYSE = ("analysis", "analyse", "--steps", "data")


@pytest.fixture
def look(visitor):
    """Return a function that looks as an open page does, each second."""

    def looks():
        visitor.console.state.now(fresh=True)
        return visitor.console._version()

    return looks


def results(data, *, later_s=LATER_S):
    """Write the table that an analysis writes, so much later than the newest run ended."""
    folder = data / "derivatives/slipscale"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "table3.csv").write_text("amplitude_um_pp,n,mean\n2.3,2,80.512\n")
    (folder / "fig15.svg").write_text("<svg/>")
    newest_s = max(path.stat().st_mtime for path in data.rglob("*.jsonl")) + later_s
    os.utime(folder / "table3.csv", (newest_s, newest_s))


def ends(data, whole_runs):
    """Have participant 02's run come to its end."""
    [path] = whole_runs.glob("sourcedata/sub-02/*.jsonl")
    (data / path.relative_to(whole_runs)).write_bytes(path.read_bytes())


def test_blind_nothing_is_computed(visitor, recorded, look):
    look()
    assert visitor.jobs.started == []


def test_unblinded_what_was_never_analysed_is(visitor, recorded, look):
    visitor.ask("unblind", word="unblind")
    look()
    look()
    assert visitor.jobs.started == [ANALYSE]


def test_when_a_run_ends_results_are_made_anew_once(visitor, recorded, look, whole_runs):
    visitor.ask("unblind", word="unblind")
    results(recorded)
    before = look()
    assert visitor.jobs.started == []  # they are newer than every run
    ends(recorded, whole_runs)
    results(recorded, later_s=-LATER_S)
    assert look() != before
    look()
    assert visitor.jobs.started == [ANALYSE]


def test_a_run_that_ended_while_the_analysis_was_at_work_is_not_forgotten(
    visitor, recorded, look, whole_runs
):
    visitor.ask("unblind", word="unblind")
    look()
    ends(recorded, whole_runs)
    results(recorded)  # by the analysis that had begun before
    look()
    assert visitor.jobs.started == [ANALYSE, ANALYSE]


def test_nothing_is_computed_beside_a_session(visitor, session, status, look):
    visitor.ask("unblind", word="unblind")
    with session(status):
        look()
        assert visitor.jobs.started == []
    look()
    assert visitor.jobs.started == [ANALYSE]


def test_a_second_console_leaves_it_to_the_first(visitor, recorded, look, make_visitor):
    second = make_visitor(type(visitor.access)(port=8471))
    visitor.ask("unblind", word="unblind")
    with visitor.client, second.client:
        second.console.state.now(fresh=True)
        second.console._version()
        assert second.jobs.started == []
        look()
    assert visitor.jobs.started == [ANALYSE]


def test_new_results_are_told_to_open_pages(visitor, recorded, look):
    """Also those of another console, or of the command line."""
    visitor.ask("unblind", word="unblind")
    results(recorded)
    before = look()
    results(recorded, later_s=2 * LATER_S)
    assert look() != before
    assert "Results of 20" in visitor.see("/data")


# At work ------------------------------------------------------------------------------------------


RULE = '\n[analysis]\nexclusions = ["zeros"]\nthresholds = { zero_share = 0.2 }\n'


def test_the_analysis_and_the_console_use_the_same_names(record_runs, tmp_path, capsys):
    """Of its steps, and of who is excluded by which rule."""
    text = study_text("biet2007") + RULE
    record_runs(tmp_path, "01", "02", study_text=text)
    assert main(["data", "build", str(tmp_path)]) == 0
    assert main(["analyse", "--steps", str(tmp_path)]) == 0
    lines = capsys.readouterr().err.splitlines()
    told = [line.removeprefix("step: ") for line in lines if line.startswith("step: ")]
    known = [key.removeprefix("step.") for key in page_texts("en") if key.startswith("step.")]
    assert told == known
    assert len(told) == 7
    people = read_roster(tmp_path, parse_study(text, "mine"), text).people
    assert [person.excluded for person in people] == [(), ("zeros",)]


def test_every_rule_that_excludes_has_its_words():
    known = {key.removeprefix("flag.") for key in page_texts("en") if key.startswith("flag.")}
    assert known == set(get_args(QualityFlag))


@pytest.fixture
def at_work(tmp_path):
    """Return a function that makes a job that is at work, of what it has written until now."""

    def make(kind, errors="", parts=0):
        path = tmp_path / f"{kind}.txt"
        path.write_text(errors)
        process = SimpleNamespace(poll=lambda: None)
        return Job(kind=kind, about="", process=process, output=path, errors=path, parts=parts)

    return make


def test_the_page_shows_the_steps_that_the_process_has_come_to(
    visitor, recorded, words_of, look, at_work
):
    visitor.ask("unblind", word="unblind")
    versions = []
    for steps in ("step: reading the data\n", "step: reading the data\nstep: testing\n"):
        visitor.jobs.jobs["analysis"] = at_work("analysis", steps)
        versions.append(look())
    page = visitor.see("/data")
    assert "reading the data testing" in words_of(page)
    assert '<li aria-current="step">testing</li>' in page
    assert versions[0] != versions[1]
    assert "lecture des données" in visitor.see("/data?lang=fr")


@pytest.mark.skipif(sys.platform == "win32", reason="priorities are POSIX")
def test_a_job_that_computes_gives_way_to_a_session_and_its_steps_are_no_complaint(lab):
    job = Jobs(lab).start("analysis", "the analysis", "analyse", "--steps", "nothing")
    assert os.getpriority(os.PRIO_PROCESS, job.process.pid) == 19
    job.process.wait()
    assert job.steps() == ["reading the data"]
    assert "nothing: no such file or folder" in job.complained()


def test_a_pilot_tells_how_far_it_has_come(visitor, lab, words_of, look, at_work):
    assert visitor.ask("pilot", participants=5, seed=1)[0] == 200
    assert visitor.jobs.parts == [5]
    visitor.jobs.jobs["pilot"] = at_work("pilot", parts=5)
    assert "0 of 5 simulated participants" in words_of(visitor.see("/pilot"))
    before = look()
    for label in ("01", "02"):
        (lab / f"pilots/001/sourcedata/sub-{label}").mkdir(parents=True)
    assert look() != before
    page = visitor.see("/pilot")
    assert "2 of 5 simulated participants" in words_of(page)
    assert '<progress max="5" value="2"' in page


def test_today_says_who_is_excluded_and_by_which_rule(visitor, recorded, lab, words_of):
    rules = '\n[analysis]\nexclusions = ["zeros", "fast"]\n'
    (lab / "mine.toml").write_text(study_text("biet2007") + rules)
    (lab / "slipscale.toml").write_text('study = "mine.toml"\nplate = "serial:COM9"\n')
    page = words_of(visitor.see("/"))
    assert "The study excludes by: zeros, fast. Who is excluded is known after" in page
    folder = recorded / "derivatives/slipscale"
    folder.mkdir(parents=True)
    (folder / "results.json").write_text(json.dumps({"excluded": {"sub-01": ["zeros"]}}))
    visitor.console.state.now(fresh=True)
    page = words_of(visitor.see("/"))
    assert "excluded many estimates of zero" in page
    assert re.search(r"The analysis of \d{4}-\d\d-\d\d \d\d:\d\d excluded 1", page)
