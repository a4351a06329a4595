"""What the pages show of the laboratory folder, and what they keep from who runs the sessions."""

import re
import shutil
import zipfile
from dataclasses import replace
from io import BytesIO
from types import SimpleNamespace

import pytest

from slipscale.experiments.dataset.schema import FLAGS
from slipscale.experiments.lab.blind_summary import EVENTS
from slipscale.experiments.lab.console.jobs import Job, Jobs
from slipscale.experiments.lab.console.page_texts import catalogue, languages
from slipscale.experiments.lab.console.plots import scatter
from slipscale.experiments.lab.folder import LabFile
from slipscale.experiments.lab.unblinding import unblinded
from slipscale.experiments.languages.texts import blanks
from slipscale.experiments.protocol_parts.registry import protocol_names
from slipscale.experiments.running.preflight import CHECKS
from slipscale.experiments.running.screen_check import SHOWN
from slipscale.experiments.session.operator import Request, SessionStatus
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.steps import Ask, EndBlock
from slipscale.experiments.steps.trial import Trial
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.levels import PARAMETERS
from slipscale.experiments.study.schema import UNITS, study_schema
from slipscale.faults import UserError
from slipscale.hardware.contact.source import SensorFault
from slipscale.hardware.errors import FAULTS
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

PAGES = ("/", "/live", "/study", "/data", "/pilot")
AGE = Ask(name="age", question=NumberQuestion(prompt="?"))
STATUS = SessionStatus(
    state="waiting",
    task="magnitudeestimation",
    trial=4,
    total=8,
    voidable=Trial(task="t", number=4, total=8),
    answered=Trial(task="t", number=3, total=8),
    asked=(AGE,),
    done=7,
    planned=12,
    plate="as commanded",
)


def words_of(page):
    """Return a page's text, without its elements."""
    body = re.sub(r"(?s)<script.*?</script>|<[^>]+>", " ", page)
    return " ".join(body.split())


def field_names():
    """Return all names that the study editor's form has for keys."""
    schema = study_schema()
    tables = [schema, *schema["$defs"].values()]
    ends = (*UNITS, "")
    varied = [each.parameter.quantity(PLATE_AMPLITUDE) for each in PARAMETERS.values()]
    yield from (quantity.nouns for quantity in varied)
    for key in (key for table in tables for key in table.get("properties", {})):
        yield key.removesuffix(next(end for end in ends if key.endswith(end)))


def test_the_languages_say_the_same_with_the_same_blanks():
    first, *others = (catalogue(language).texts for language in languages())
    # What a setting means is said in English by the schema of slipscale.toml.
    described = {f"setting_why.{key}" for key in LabFile.model_fields}
    # The study's schema and its protocols say in English what its keys and tasks are called.
    named = {f"field.{name}" for name in field_names()} | {
        f"task_title.{name}" for name in protocol_names()
    }
    for found in others:
        assert set(found) == set(first) | described | named
        other = {key: text for key, text in found.items() if key not in described | named}
        assert {key: blanks(text) for key, text in other.items()} == {
            key: blanks(text) for key, text in first.items()
        }


def test_no_page_shows_a_name_that_only_the_data_use(visitor, recorded, words_of):
    names = [f"trial_flag.{flag}" for flag in FLAGS]
    names += [f"check.{name}" for name in CHECKS] + [f"event.{kind}" for kind in EVENTS]
    names += [f"fault.{code}" for code in ("fault", *FAULTS, SensorFault.code)]
    names += [f"screens.{step.__name__}" for step in (*SHOWN, EndBlock)]
    for language in languages():
        assert [name for name in names if name not in catalogue(language).texts] == []
    found = words_of(visitor.see("/person?label=01", **{"accept-language": "fr"}))
    assert "passage 01 complet" in found
    assert "run 01" not in found


@pytest.mark.parametrize("path", PAGES)
def test_every_page_is_whole_before_anybody_has_come(visitor, path):
    assert "</html>" in visitor.see(path)


@pytest.mark.parametrize("path", PAGES)
def test_every_page_speaks_the_readers_language(visitor, recorded, path):
    assert '<html lang="fr">' in visitor.see(path, **{"accept-language": "fr-CH, en;q=0.4"})
    assert '<html lang="en">' in visitor.see(f"{path}?lang=en", **{"accept-language": "fr"})


def test_today_shows_who_is_where_and_offers_what_can_be_done(visitor, recorded):
    page = visitor.see("/")
    assert "2 of 12 planned participants have started; 1 finished" in words_of(page)
    assert "participant 03" in words_of(page)
    assert page.count('data-do="resume"') == 2  # on the card, and in the table
    assert page.index('class="main">Resume participant 02') < page.index(">Begin the session")
    assert page.count('data-do="begin"') == 2


def test_on_a_plate_that_nobody_feels_only_rehearsals_are_offered(visitor, recorded, lab):
    (lab / "slipscale.toml").write_text('plate = "mock"\n')
    page = visitor.see("/")
    assert "is simulated; participants cannot feel it" in page
    assert page.count('data-do="begin"') == 1
    assert visitor.ask("begin", participant="03")[0] == 409
    assert visitor.ask("begin", participant="01", pilot=True)[0] == 200


# The running session ------------------------------------------------------------------------------


def test_live_shows_where_the_session_is(visitor, session):
    with session(STATUS):
        said = words_of(visitor.see("/live"))
    assert "Trial 4 of 8" in said
    assert "session: 7 of 12 trials" in said
    assert "settled, on target" in said
    assert "participant 02, run 01 · study biet2007" in said


@pytest.mark.parametrize("path", PAGES)
def test_no_page_shows_an_amplitude_of_the_running_session(visitor, session, lab, path):
    """The study file's own page lists them, in no order of presentation."""
    with session(STATUS):
        page = visitor.see(path)
    if path != "/study":
        assert "µm" not in page
        assert "um_pp" not in page


def test_a_session_that_was_told_to_unblind_shows_its_amplitude(visitor, session):
    with session(replace(STATUS, level="1.2 µm p-p", unblinded=True)):
        assert "1.2 µm p-p" in words_of(visitor.see("/live"))


def test_faults_are_told_by_their_code_alone(visitor, session):
    with session(STATUS) as (_, journal):
        journal.write("fault", code="not_reached", message="2.3 µm p-p was commanded")
        page = visitor.see("/live")
    assert "the plate did not reach the amplitude" in page
    assert "2.3" not in page


def test_what_is_asked_on_the_page_reaches_the_session(visitor, session):
    with session(STATUS) as (box, _):
        token = re.search(r"&#34;token&#34;: &#34;([0-9a-f]+)", visitor.see("/live"))[1]
        assert visitor.ask("ask", token=token, what="pause")[0] == 200
        assert box.poll() == Request(what="pause")
        assert (
            visitor.ask("ask", token=token, what="void", reason="slip", task="t", trial=3)[0] == 200
        )
        assert box.poll() == Request(what="void", reason="slip", trial=STATUS.answered)
        assert visitor.ask("ask", token=token, what="ask_again", question="age")[0] == 200
        assert box.poll() == Request(what="ask_again", question=AGE)
        status, said = visitor.ask("ask", token=token, what="note", reason=" ")
        assert (status, "expected a text" in said) == (409, True)
    status, said = visitor.ask("ask", token=token, what="stop")
    assert (status, said) == (409, "that session is over")


def test_what_a_participant_says_is_entered_on_the_page(visitor, session):
    asking = Ask(name="x", question=NumberQuestion(prompt="How <slippery>?"), by="operator")
    with session(replace(STATUS, answering=asking)) as (box, _):
        page = visitor.see("/live")
        assert "Enter the answer" in page
        assert "How &lt;slippery&gt;?" in page
        given = {"token": box._token, "what": "answer", "task": STATUS.task, "trial": STATUS.trial}
        assert visitor.ask("ask", **given, reason="")[0] == 409
        assert visitor.ask("ask", **given, reason="12.5")[0] == 200
        assert (request := box.poll())
        assert (request.what, request.reason) == ("answer", "12.5")


def test_two_consoles_see_the_same_session_and_both_may_ask(visitor, session, make_visitor):
    other = make_visitor(replace(visitor.access, port=8471))
    other.client.cookies.set(other.access.cookie, other.access.entrance.secret)
    with session(STATUS) as (box, _):
        seen = (words_of(each.see("/live")) for each in (visitor, other))
        changing = r"time since the start \d+:\d\d|[\d.]+ GB free"
        pages = [re.sub(changing, "", page) for page in seen]
        assert pages[0] == pages[1]
        token = box._token
        assert visitor.ask("ask", token=token, what="pause")[0] == 200
        assert box.poll() == Request(what="pause")


def test_while_a_session_runs_no_other_begins_and_nothing_checks_the_plate(visitor, session):
    with session(STATUS):
        for action, fields in {
            "begin": {"participant": "03"},
            "check": {},
            "resume": {"participant": "02", "session": "", "run": "01"},
        }.items():
            status, said = visitor.ask(action, **fields)
            assert (status, "is running; end it first" in said) == (409, True)
        assert "The session of participant 02 is running" in words_of(visitor.see("/"))
    assert visitor.jobs.started == []


def test_a_session_without_a_mailbox_is_shown_and_says_so(visitor, session, recorded):
    with session(STATUS):
        shutil.rmtree(next(recorded.rglob("*.live")))
        visitor.console.state.now(fresh=True)
        assert "reports no status and accepts no requests" in visitor.see("/live")


def test_a_message_of_a_change_comes_once_for_each_change(visitor, session):
    first = visitor.console._version()
    assert visitor.console._version() == first
    with session(STATUS):
        visitor.console.state.now(fresh=True)
        assert visitor.console._version() != first


# Actions ------------------------------------------------------------------------------------------


def test_a_session_begins_as_slipscale_next_would(visitor, recorded):
    assert visitor.ask("begin", participant="03")[0] == 200
    assert visitor.jobs.started == [("session", "next", "--yes", "--participant", "03")]
    status, said = visitor.ask("begin", participant="07")
    assert (status, "is no longer next" in said) == (409, True)


def test_while_a_session_begins_or_ends_no_other_is_offered(visitor, recorded):
    """Its process is there, and nobody writes its journal: a press would be refused."""
    process = SimpleNamespace(poll=lambda: None)
    path = recorded / "nothing.txt"
    job = Job(kind="session", about="participant 03", process=process, output=path, errors=path)
    visitor.jobs.jobs["session"] = job
    page = visitor.see("/")
    assert "participant 03: the session is starting or ending" in words_of(page)
    assert "data-do=" not in page
    status, said = visitor.ask("begin", participant="03")
    assert (status, "still running" in said) == (409, True)


def test_an_interrupted_run_goes_on_as_slipscale_resume_would(visitor, recorded):
    assert visitor.ask("resume", participant="02", session="", run="01")[0] == 200
    [(kind, command, path)] = visitor.jobs.started
    assert (kind, command) == ("session", "resume")
    assert path.endswith("sub-02_run-01_journal.jsonl")
    assert visitor.ask("resume", participant="01", session="", run="01")[0] == 409


# The blind ----------------------------------------------------------------------------------------


@pytest.fixture
def analysed(recorded):
    results = recorded / "derivatives/slipscale"
    results.mkdir(parents=True)
    (results / "table3.csv").write_text("amplitude_um_pp,n,mean\n2.3,2,80.512\n")
    (results / "report.html").write_text("<h1>80.512</h1>")
    (results / "fig15.svg").write_text("<svg/>")
    return recorded


def test_results_are_kept_back_until_somebody_unblinds_and_that_is_written_down(visitor, analysed):
    for path in ("/data", "/data/report", "/data/report.html", "/data/fig15.svg"):
        answer = visitor.client.get(path)
        assert "80.51" not in answer.text
        assert answer.status_code == (200 if path == "/data" else 404)
    assert visitor.ask("analyse")[0] == 409
    assert visitor.ask("unblind", word="yes")[0] == 409
    assert unblinded(analysed) == []
    assert visitor.ask("unblind", word="Unblind")[0] == 200
    assert len(unblinded(analysed)) == 1
    assert "80.51" in visitor.see("/data")
    assert "80.512" in visitor.see("/data/report.html")
    assert visitor.ask("analyse")[0] == 200
    assert visitor.jobs.started == [("analysis", "analyse", "--steps", "data")]


def test_a_job_at_work_is_shown_and_one_that_failed_says_why(visitor, analysed, lab):
    visitor.ask("unblind", word="unblind")
    job = Jobs(lab).start("analysis", "the analysis", "analyse", "nothing")
    visitor.jobs.jobs["analysis"] = job
    if job.running:  # it is, unless this machine is very quick
        assert "The analysis is running" in words_of(visitor.see("/data"))
    job.process.wait()
    assert "The analysis failed: nothing: no such file" in words_of(visitor.see("/data"))


def test_unblinding_in_the_middle_of_a_session_stands_in_its_journal(visitor, session):
    with session(STATUS) as (box, _):
        visitor.ask("unblind", word="voir")
        request = box.poll()
    assert (request.what, "unblinded" in request.reason) == ("note", True)


def test_once_all_planned_are_done_results_are_shown(visitor, analysed, lab, monkeypatch):
    text = study_text("biet2007").replace("participants = 12", "participants = 1")
    (lab / "one.toml").write_text(text)
    (lab / "slipscale.toml").write_text('study = "one.toml"\nplate = "serial:COM9"\n')
    assert "80.51" in visitor.see("/data")
    assert unblinded(analysed) == []


def test_data_shows_how_runs_went_and_no_answer(visitor, recorded):
    page = visitor.see("/data")
    assert page.count("<circle") > 10
    assert "complete" in words_of(page)
    assert "µm" not in page


def test_the_download_is_the_data_set_without_locks_and_mailboxes(visitor, session, recorded):
    with session(STATUS):
        content = visitor.client.get("/data/download").content
    names = zipfile.ZipFile(BytesIO(content)).namelist()
    assert "data/sourcedata/sub-01/sub-01_run-01_journal.jsonl" in names
    assert not [name for name in names if ".live" in name or name.endswith(".lock")]


def test_response_times_are_scaled_by_most_of_them_and_none_is_lost():
    found = scatter([[1.0, 2.0, 3.0], [1.5, 2.5, 900.0]])
    assert len(found.points) == 6
    assert min(y for _, y in found.points) >= 10
    assert scatter([]) is None
    assert scatter([[]]) is None


# Pilots -------------------------------------------------------------------------------------------


def test_pilots_are_listed_with_their_reports(visitor, lab):
    for number, reported in (("001", True), ("002", False)):
        folder = lab / "pilots" / number / "derivatives/slipscale"
        folder.mkdir(parents=True)
        if reported:
            (folder / "report.html").write_text("<p>it worked</p>")
    page = visitor.see("/pilot")
    assert "/pilot/001/report" in page
    assert "/pilot/002/report" not in page
    assert "it worked" in visitor.see("/pilot/001/report.html")
    assert visitor.ask("pilot", participants=3, seed=1)[0] == 200
    assert visitor.jobs.started == [("pilot", "pilot", "--participants", "3", "--seed", "1")]


def test_an_unblinding_record_that_cannot_be_read_is_told(recorded):
    (recorded / "sourcedata/unblinded.json").write_text("[1]")
    with pytest.raises(UserError, match="cannot be read"):
        unblinded(recorded)
