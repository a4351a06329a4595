"""Results that grow by themselves, once they may be seen, and the analysis at work."""

import csv
import json
import os
import re
import sys
from types import SimpleNamespace
from typing import get_args

import pytest

from slipscale.commands import main
from slipscale.experiments.lab.console import jobs as job_file
from slipscale.experiments.lab.console.jobs import Job, Jobs
from slipscale.experiments.lab.console.page_texts import catalogue
from slipscale.experiments.lab.curves import curves
from slipscale.experiments.lab.roster import read_roster
from slipscale.experiments.study.analysis_choices import QualityFlag
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

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


#: Three of four answers of the second participant, and one of the first, came within 3 s.
RULE = '\n[analysis]\nexclusions = ["fast"]\nthresholds = { fast_s = 3.0, fast_share = 0.5 }\n'


def test_the_analysis_and_the_console_use_the_same_names(record_runs, tmp_path, capsys):
    """Of its steps, and of who is excluded by which rule."""
    text = study_text("biet2007") + RULE
    record_runs(tmp_path, "01", "02", study_text=text)
    assert main(["data", "build", str(tmp_path)]) == 0
    assert main(["analyse", "--steps", str(tmp_path)]) == 0
    lines = capsys.readouterr().err.splitlines()
    told = [line.removeprefix("step: ") for line in lines if line.startswith("step: ")]
    known = [key.removeprefix("step.") for key in catalogue("en").texts if key.startswith("step.")]
    assert told == known
    assert len(told) == 7
    people = read_roster(tmp_path, parse_study(text, "mine"), text).people
    assert [person.excluded for person in people] == [(), ("fast",)]


def test_every_rule_that_excludes_has_its_words():
    known = {key.removeprefix("flag.") for key in catalogue("en").texts if key.startswith("flag.")}
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
    assert "reading the data running the tests" in words_of(page)
    assert '<li aria-current="step">running the tests</li>' in page
    assert versions[0] != versions[1]
    assert "lecture des données" in visitor.see("/data?lang=fr")


@pytest.mark.skipif(sys.platform == "win32", reason="priorities are POSIX")
def test_a_job_that_computes_gives_way_to_a_session_and_its_steps_are_no_complaint(
    lab, monkeypatch
):
    assert job_file.LEAST_URGENT == 19
    monkeypatch.setattr(job_file, "LEAST_URGENT", 1)  # on a busy machine, 19 could take minutes
    job = Jobs(lab).start("analysis", "the analysis", "analyse", "--steps", "nothing")
    assert os.getpriority(os.PRIO_PROCESS, job.process.pid) == 1
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
    rules = "Exclusion criteria in this study: many estimates of zero, answers too fast."
    assert f"{rules} Run an analysis to see who is excluded" in page
    folder = recorded / "derivatives/slipscale"
    folder.mkdir(parents=True)
    (folder / "results.json").write_text(json.dumps({"excluded": {"sub-01": ["zeros"]}}))
    visitor.console.state.now(fresh=True)
    page = words_of(visitor.see("/"))
    assert "excluded many estimates of zero" in page
    assert re.search(r"excluded by the analysis of \d{4}-\d\d-\d\d \d\d:\d\d: 1\.", page)


def test_the_whole_data_set_is_verified_rebuilt_and_exported_by_processes(visitor, recorded):
    assert visitor.ask("work", what="export")[0] == 409  # it would unblind
    assert visitor.client.get("/data/export").status_code == 404
    visitor.ask("unblind", word="unblind")
    for what in ("verify", "build", "export"):
        assert visitor.ask("work", what=what) == (200, f"started: {what}")
    assert visitor.jobs.started == [
        ("verify", "data", "verify", "data", "--json"),
        ("build", "data", "build", "data", "--json"),
        ("export", "export", "data", "--out", "data/derivatives/slipscale/export"),
    ]
    out = recorded / "derivatives/slipscale/export"
    out.mkdir(parents=True)
    (out / "report.docx").write_bytes(b"x")
    assert visitor.client.get("/data/export").content.startswith(b"PK")


def test_what_a_job_on_the_data_set_found_is_listed(visitor, recorded, words_of):
    problem = {"file": "participants.tsv", "place": "row 2", "what": "differs"}
    for said, shown in (([problem], "participants.tsv row 2 differs"), ([], "no problem found")):
        output = recorded / "output.txt"
        output.write_text(json.dumps(said))
        visitor.jobs.jobs["verify"] = SimpleNamespace(
            running=False,
            status=int(bool(said)),
            output=output,
            said=output.read_text,
            complained=lambda: "",
            steps=list,
        )
        assert shown in words_of(visitor.see("/data"))


def test_runs_are_searched_filtered_and_sorted_by_the_address(visitor, recorded):
    def labels(address):
        return re.findall(r'<th scope="row"><a href="/person\?label=(\d+)', visitor.see(address))

    assert labels("/data") == ["02", "01"]
    assert labels("/data?sort=participant") == ["01", "02"]
    assert labels("/data?sort=trials&down=1") == ["01", "02"]
    assert labels("/data?state=interrupted") == ["02"]
    assert labels("/data?search=nothing+such") == []


def test_curves_appear_once_results_may_be_seen_with_the_tables_means(visitor, recorded, words_of):
    main(["data", "build", str(recorded)])
    assert 'id="curves"' not in visitor.see("/data")
    visitor.ask("unblind", word="unblind")
    assert 'id="curves"' in visitor.see("/data")
    assert 'id="curves"' in visitor.see("/person?label=01")
    estimated, *_ = [c for c in curves(recorded, PLATE_AMPLITUDE, "01") if c.y == "estimate"]
    [path] = recorded.rglob("sub-01_task-magnitudeestimation_run-01_beh.tsv")
    rows = list(csv.DictReader(path.read_text().splitlines(), delimiter="\t"))
    main_rows = [row for row in rows if row["phase"] == "main"]
    assert estimated.points == tuple(
        sorted((float(r["amplitude_um_pp"]), float(r["estimate"])) for r in main_rows)
    )


def test_a_press_copies_what_no_backup_has_and_exclusions_follow(visitor, recorded, lab):
    assert visitor.ask("backup")[0] == 409
    (lab / "disk").mkdir()
    (lab / "slipscale.toml").write_text('plate = "serial:COM9"\nbackup = "disk"\n')
    assert visitor.ask("backup") == (200, "copied 2 runs to disk")
    assert visitor.ask("backup") == (200, "copied 0 runs to disk")
    visitor.ask("exclude", participant="01", excluded=True, reason="a glove")
    copy = lab / "disk/data/sourcedata/sub-01/excluded.json"
    assert copy.read_bytes() == (recorded / "sourcedata/sub-01/excluded.json").read_bytes()
    visitor.ask("withdraw", participant="01", word="01")
    assert not copy.exists()
