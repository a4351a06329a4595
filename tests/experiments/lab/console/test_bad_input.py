"""Whatever is odd or wrong with the laboratory has its sentence on the page."""

import shutil
import socket
from contextlib import ExitStack
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest

from slipscale.commands import main
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.lab.console import state
from slipscale.experiments.lab.console.presence import Presence
from slipscale.experiments.lab.console.security import Access
from slipscale.experiments.study.file import study_text
from slipscale.hardware.clock import VirtualClock

PAGES = ("/", "/live", "/study", "/data", "/pilot")


def journal_of(lab, number, folder="data"):
    return next((lab / folder / f"sourcedata/sub-{number}").glob("*_journal.jsonl"))


# What makes the folder unusable ------------------------------------------------------------------

UNUSABLE = {
    "the file of the folder is gone": (
        lambda lab: (lab / "slipscale.toml").unlink(),
        "slipscale.toml is missing",
    ),
    "the file of the folder is no TOML": (
        lambda lab: (lab / "slipscale.toml").write_text("study ="),
        "is not TOML",
    ),
    "a key of it is unknown": (
        lambda lab: (lab / "slipscale.toml").write_text("platte = 1"),
        "unknown key",
    ),
    "the study is gone": (
        lambda lab: (lab / "slipscale.toml").write_text('study = "s.toml"'),
        "No such file",
    ),
    "the study has a fault": (
        lambda lab: (
            (lab / "s.toml").write_text("name = 1"),
            (lab / "slipscale.toml").write_text('study = "s.toml"'),
        ),
        "line 1, name",
    ),
    "who withdrew cannot be read": (
        lambda lab: (lab / "data/sourcedata/withdrawn.json").write_text("{"),
        "withdrawn.json: cannot be read",
    ),
    "who unblinded cannot be read": (
        lambda lab: (lab / "data/sourcedata/unblinded.json").write_text("{"),
        "unblinded.json: cannot be read",
    ),
}


@pytest.mark.parametrize("case", UNUSABLE)
def test_what_is_wrong_with_the_folder_is_a_sentence_on_every_page(visitor, recorded, lab, case):
    break_it, sentence = UNUSABLE[case]
    visitor.see("/")
    break_it(lab)
    visitor.console.state.now(fresh=True)
    for path in PAGES:
        assert sentence in visitor.see(path)
    status, said = visitor.ask("check")
    assert (status, sentence in said) == (409, True)


def test_a_folder_that_has_gone_while_the_page_is_open(
    visitor, recorded, lab, tmp_path_factory, monkeypatch
):
    gone = tmp_path_factory.mktemp("gone")
    monkeypatch.chdir(gone)
    gone.rmdir()
    visitor.console.state.now(fresh=True)
    for path in PAGES:
        assert "laboratory folder is missing" in visitor.see(path)
    monkeypatch.chdir(lab)


# What is odd, and stops nothing ------------------------------------------------------------------


def damaged(lab, _):
    path = journal_of(lab, "02")
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:5], b"rubbish\n", *lines[6:]]))


def two_sessions(lab, stack):
    rehearsal = lab / "pilots/rehearsals/sourcedata/sub-02"
    shutil.copytree(lab / "data/sourcedata/sub-02", rehearsal)
    for folder in ("data", "pilots/rehearsals"):
        stack.enter_context(Journal.reopen(journal_of(lab, "02", folder), VirtualClock()))


def set_back(_, stack):
    past = datetime.now(UTC) - timedelta(days=3)
    patch = stack.enter_context(pytest.MonkeyPatch.context())
    patch.setattr(state, "datetime", SimpleNamespace(now=lambda _: past))


def edited(lab, _):
    (lab / "biet.toml").write_text(study_text("biet2007").replace("seed = 2007", "seed = 8"))
    (lab / "slipscale.toml").write_text('study = "biet.toml"\nplate = "serial:COM9"\n')


def another_console(lab, stack):
    other = Presence(lab, 8499)
    other.announce()
    stack.callback(other.close)


ODD = {
    "a journal is damaged": (damaged, "participant 02 (run 01) is damaged at line 6"),
    "two sessions run": (
        two_sessions,
        "2 sessions are running: participant 02 (run 01), participant 02 (run 01)",
    ),
    "the clock was set back": (set_back, "the clock of this computer was changed"),
    "the study was edited between participants": (
        edited,
        "biet.toml has been edited since participants took part (01, 02)",
    ),
    "another console is open": (another_console, "is open (port 8499)"),
}


@pytest.mark.parametrize("case", ODD)
def test_what_is_odd_is_a_sentence_on_every_page_and_stops_nothing(
    visitor, recorded, lab, words_of, case
):
    make_it, sentence = ODD[case]
    assert sentence not in words_of(visitor.see("/"))
    version = visitor.console._version()
    with ExitStack() as stack:
        make_it(lab, stack)
        found = visitor.console.state.now(fresh=True)
        assert found.problem == ""
        assert visitor.console._version() != version
        for path in PAGES:
            assert sentence in words_of(visitor.see(path))


def test_in_good_order_there_is_no_such_sentence(visitor, recorded):
    for path in PAGES:
        assert 'class="banner' not in visitor.see(path)


def test_a_console_that_was_killed_is_not_taken_for_open(tmp_path):
    """Its file is there, and nobody holds it."""
    killed = Presence(tmp_path, 8498)
    killed.announce()
    killed._held.close()
    own = Presence(tmp_path, 8499)
    own.announce()
    assert (own.others(), own.first(), own.notices()) == ([], True, ())
    assert not killed._own.exists()
    own.close()


def test_of_two_consoles_the_first_does_what_is_done_once(tmp_path):
    one, two = Presence(tmp_path, 8498), Presence(tmp_path, 8499)
    one.announce()
    two.announce()
    assert (one.first(), two.first()) == (True, False)
    assert (one.others(), two.others()) == ([8499], [8498])
    one.close()
    assert two.first()
    two.close()


def test_a_phone_that_looks_on_is_no_second_console(lab, make_visitor, visitor):
    phone = make_visitor(Access(host="192.168.0.12", port=8471, tls=True, read_only=True))
    with phone.client:
        assert visitor.console.presence.others() == []


@pytest.fixture
def five_hundred(lab, whole_runs):
    source = next(whole_runs.glob("sourcedata/sub-01/*.jsonl")).read_bytes().splitlines(True)
    for number in range(1, 501):
        folder = lab / f"data/sourcedata/sub-{number:03d}"
        folder.mkdir(parents=True)
        whole = b"".join(source) if number <= 100 else source[0]
        (folder / f"sub-{number:03d}_run-01_journal.jsonl").write_bytes(whole)


def test_of_five_hundred_participants_those_who_wait_are_shown_and_all_at_a_press(
    visitor, five_hundred, words_of
):
    page = visitor.see("/")
    assert page.count('<th scope="row">') == 60
    assert "500 of 12 planned participants have started; 100 finished" in words_of(page)
    assert "60 of 500 participants are shown: those who need an action" in words_of(page)
    assert page.count("tag interrupted") == 60
    assert visitor.see("/?all=1").count('<th scope="row">') == 500
    data = visitor.see("/data")
    assert data.count('<th scope="row">') == 60
    assert "The last 60 of 500 runs are shown" in words_of(data)
    assert visitor.see("/data?all=1").count('<th scope="row">') == 500


# What a page can only say by not being there: the terminal says it --------------------------------


def test_a_port_that_is_taken_names_the_way_out(lab, capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["lab", "--no-browser", "--port", str(port)]) == 2
    said = capsys.readouterr().err
    assert f"port {port}" in said
    assert "--port" in said
