"""A laboratory folder with a console that is asked as a browser would."""

import re
from contextlib import contextmanager
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.lab.console.app import make_app
from slipscale.experiments.lab.console.security import Access
from slipscale.experiments.lab.folder import init
from slipscale.experiments.session import mailbox as mailboxes
from slipscale.experiments.session.mailbox import Mailbox, mailbox_of
from slipscale.experiments.session.operator import SessionStatus
from slipscale.experiments.steps.trial import Trial
from slipscale.hardware.clock import VirtualClock

ADDRESS = "http://127.0.0.1:8470"
ASKING = {"origin": ADDRESS, "x-slipscale": "1", "content-type": "application/json"}


class Noted:
    """In place of processes: what would have been started."""

    def __init__(self):
        self.started, self.parts = [], []
        self.jobs = {}

    def last(self, kind):
        return self.jobs.get(kind)

    def start(self, kind, _about, *words, parts=0):
        self.started.append((kind, *words))
        self.parts.append(parts)


class Visitor:
    """A browser that has opened the printed address."""

    def __init__(self, access, jobs):
        app, self.console = make_app(access, jobs)
        address = access.address.partition("/?")[0]
        self.client = TestClient(app, base_url=address, follow_redirects=False)
        self.access, self.jobs = access, jobs
        self.client.cookies.set(access.cookie, access.entrance.secret)

    def see(self, path="/", **headers):
        answer = self.client.get(path, headers={"accept-language": "en", **headers})
        assert answer.status_code == 200, answer.text
        return answer.text

    def ask(self, action, **fields):
        answer = self.client.post(f"/do/{action}", json=fields, headers=ASKING)
        return answer.status_code, answer.json()["said"]

    def edit(self, text, part="edit", **fields):
        return self.client.post(f"/study/{part}", json={"text": text, **fields}, headers=ASKING)


@pytest.fixture
def lab(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runtime = tmp_path.with_name(f"{tmp_path.name}-runtime")
    runtime.mkdir(mode=0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime))
    init(tmp_path, {"plate": "serial:COM9"}, None)
    return tmp_path


@pytest.fixture
def words_of():
    """Return a function that returns a page's text, without its elements."""
    return lambda page: " ".join(re.sub(r"(?s)<script.*?</script>|<[^>]+>", " ", page).split())


@pytest.fixture
def status():
    """Return what a session tells in the middle of a trial."""
    return SessionStatus(
        state="waiting",
        task="magnitudeestimation",
        trial=4,
        total=8,
        voidable=Trial(task="t", number=4, total=8),
        done=7,
        planned=12,
        plate="as commanded",
    )


@pytest.fixture
def make_visitor():
    return lambda access: Visitor(access, Noted())


@pytest.fixture
def visitor(lab, make_visitor):
    return make_visitor(Access(port=8470))


@pytest.fixture
def asking():
    """Return the headers that the console's own script sends."""
    return ASKING


@pytest.fixture(scope="session")
def whole_runs(tmp_path_factory, record_runs):
    """Record two participants once, for all tests."""
    return record_runs(tmp_path_factory.mktemp("runs"), "01", "02", mode="participant")


@pytest.fixture
def recorded(lab, whole_runs):
    """Put the runs of participants 01 and 02 into the laboratory folder; 02's is interrupted."""
    for path in whole_runs.rglob("*_journal.jsonl"):
        copy = lab / "data" / path.relative_to(whole_runs)
        copy.parent.mkdir(parents=True)
        lines = path.read_bytes().splitlines(keepends=True)
        copy.write_bytes(b"".join(lines[:40] if "sub-02" in path.name else lines))
    return lab / "data"


@pytest.fixture
def session(recorded, monkeypatch):
    """Return a function that has participant 02's session run, with its mailbox."""
    monkeypatch.setattr(mailboxes, "LOOK_S", 0.0)
    path = next((recorded / "sourcedata/sub-02").glob("*_journal.jsonl"))

    @contextmanager
    def running(status):
        with (
            Journal.reopen(path, VirtualClock()) as journal,
            Mailbox(mailbox_of(Path(path)), ("participant 02, run 01", "study biet2007")) as box,
        ):
            box.tell(status)
            yield box, journal

    return running
