"""The page of a participant: what happened, exclusion by hand, withdrawal."""

from pathlib import Path

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.hand_exclusions import excluded_by_hand
from slipscale.experiments.dataset.withdrawn import withdrawn
from slipscale.experiments.lab.answers import answered_trials
from slipscale.hardware.errors import ConnectionLost, NotReached
from slipscale.stimuli.quantity import PLATE_AMPLITUDE


def test_runs_flags_events_and_consent_are_shown_without_an_answer(visitor, recorded, words_of):
    page = words_of(visitor.see("/person?label=01"))
    assert "Participant 01" in page
    assert "run 01 complete" in page
    assert "not asked" in page
    assert "There were no faults, pauses, notes or voided trials." in page
    assert "um" not in page.split()
    assert 'href="/person?label=02"' in visitor.see("/")
    assert 'href="/person?label=02"' in visitor.see("/data")
    assert "Resume" in words_of(visitor.see("/person?label=02"))


@pytest.mark.parametrize("label", ["09", "", "../../etc", "<script>"])
def test_somebody_who_is_not_there_is_said_to_be_not_there(visitor, recorded, label):
    page = visitor.see(f"/person?label={label}")
    assert "Unknown participant" in page
    assert "<script>&" not in page


def test_notes_and_faults_of_a_run_are_listed_with_their_time(visitor, session, status, words_of):
    with session(status) as (_, journal):
        journal.write("note", text="a door <slammed>")
        journal.write("fault", code="TRIP")
    page = words_of(visitor.see("/person?label=02"))
    assert "note a door &lt;slammed&gt;" in page
    assert "fault TRIP" in page


def test_a_recorded_fault_is_shown_in_the_readers_language_unless_it_may_tell_a_level(
    visitor, session, status, words_of
):
    shown = ConnectionLost("{port}: the board restarted, so its output is off", port="COM9")
    withheld = NotReached("the plate makes {level} µm", level=1.2345)
    with session(status) as (_, journal):
        for fault in (shown, withheld):
            journal.write("fault", **fault.record())
    english = words_of(visitor.see("/person?label=02"))
    assert "the connection was lost: COM9: the board restarted, so its output is off" in english
    french = words_of(visitor.see("/person?label=02", **{"accept-language": "fr"}))
    assert "COM9 : la carte a redémarré, sa sortie est coupée" in french
    for page in (english, french):
        assert "1.2345" not in page


def test_an_exclusion_by_hand_is_written_shown_and_taken_back(visitor, recorded, words_of):
    asked = {"participant": "01", "excluded": True, "reason": "wore a glove"}
    assert visitor.ask("exclude", **asked)[0] == 200
    assert excluded_by_hand(recorded)["01"].results_seen is False
    page = words_of(visitor.see("/person?label=01"))
    assert "excluded: wore a glove" in page
    assert "Include again" in page
    assert "is already excluded" in visitor.ask("exclude", **asked)[1]
    assert visitor.ask("exclude", **asked | {"excluded": False})[0] == 200
    assert "Exclude from the analysis" in words_of(visitor.see("/person?label=01"))


def test_decisions_that_cannot_be_read_are_told_and_not_overwritten(visitor, recorded, words_of):
    path = recorded / "sourcedata/sub-01/excluded.json"
    path.write_text("{")
    page = words_of(visitor.see("/person?label=01"))
    assert "excluded.json" in page
    assert "Exclude from the analysis" not in page
    assert visitor.ask("exclude", participant="01", excluded=True, reason="x")[0] == 409


def test_a_withdrawal_needs_the_label_typed_and_removes_all(visitor, recorded, words_of):
    build_dataset(recorded)
    status, said = visitor.ask("withdraw", participant="01", word="02")
    assert (status, "expected the participant's label, 01" in said) == (409, True)
    assert (recorded / "sub-01").exists()
    assert visitor.ask("withdraw", participant="01", word=" 01 ")[0] == 200
    assert withdrawn(recorded) == ["01"]
    assert not list(recorded.rglob("sub-01*"))
    page = words_of(visitor.see("/person?label=01"))
    assert "This participant withdrew." in page
    assert "Remove all their data" not in page


def test_nobody_is_withdrawn_while_a_session_runs(visitor, session, status, recorded):
    with session(status):
        code, said = visitor.ask("withdraw", participant="01", word="01")
        assert (code, "is running" in said) == (409, True)
        assert "Remove all their data" not in visitor.see("/person?label=01")
    assert (recorded / "sourcedata/sub-01").exists()


def test_rehearsals_have_pages_too_and_their_own_decisions(visitor, lab, record_runs, words_of):
    record_runs(lab / "pilots/rehearsals", "01", mode="pilot")
    assert "Unknown participant" in visitor.see("/person?label=01")
    assert "rehearsal" in words_of(visitor.see("/person?label=01&pilot=1"))
    asked = {"participant": "01", "excluded": True, "reason": "r", "pilot": True}
    assert visitor.ask("exclude", **asked)[0] == 200
    assert list(excluded_by_hand(lab / "pilots/rehearsals")) == ["01"]


def test_a_rehearsal_shows_its_answers_report_and_screens_and_is_marked(
    visitor, lab, record_runs, words_of
):
    rehearsals = lab / "pilots/rehearsals"
    record_runs(rehearsals, "01", mode="pilot")
    page = visitor.see("/person?label=01&pilot=1")
    words = words_of(page)
    assert "PILOT: these answers are not data" in words
    assert "Answers: run 01" in words
    (first, *_) = answered_trials(next(rehearsals.rglob("*_journal.jsonl")), PLATE_AMPLITUDE)
    assert first.answers
    assert f"{first.number} {' → '.join(first.presented)} " in words
    assert 'href="/screens"' in page
    assert "/pilot/rehearsals/report" not in page
    assert visitor.ask("analyse", pilot=True) == (200, "analysing")
    assert visitor.jobs.started == [
        ("rehearsals", "analyse", "--steps", str(Path("pilots/rehearsals")))
    ]
    results = rehearsals / "derivatives/slipscale"
    results.mkdir(parents=True)
    (results / "report.html").write_text("<p>it worked</p>")
    for path in ("/person?label=01&pilot=1", "/pilot"):
        assert 'href="/pilot/rehearsals/report"' in visitor.see(path)
    assert "it worked" in visitor.see("/pilot/rehearsals/report.html")
    assert "Rehearsals: 1, with their answers and report" in words_of(visitor.see("/data"))


def test_a_simulated_pilot_shows_its_answers_and_decides_about_nobody(
    visitor, lab, record_runs, words_of
):
    record_runs(lab / "pilots/001", "01", mode="pilot")
    assert "/person?label=01&amp;pilot=001" in visitor.see("/pilot")
    words = words_of(visitor.see("/person?label=01&pilot=001"))
    assert "simulated pilot 001" in words
    assert "Answers: run 01" in words
    assert "Remove all their data" not in words
    assert "Exclude from the analysis" not in words


def test_answers_of_participants_stay_hidden(visitor, recorded, words_of):
    words = words_of(visitor.see("/person?label=01"))
    assert "Answers" not in words
    assert "PILOT" not in words
    assert answered_trials(lab_file(recorded), PLATE_AMPLITUDE)


def lab_file(recorded):
    return next((recorded / "sourcedata/sub-01").glob("*_journal.jsonl"))


def test_a_console_that_only_shows_offers_neither(lab, recorded, make_visitor):
    from slipscale.experiments.lab.console.security import Access

    page = make_visitor(Access(port=8470, read_only=True)).see("/person?label=01")
    assert 'data-do="withdraw"' not in page
    assert 'data-do="exclude"' not in page
