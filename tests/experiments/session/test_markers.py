"""Markers, from whole sessions to receivers outside: a stream, a pseudo-terminal, a port."""

import os
import subprocess
import sys
import tty
import types

import pytest

from slipscale import commands
from slipscale.experiments.journal.plan_and_progress import last_markers
from slipscale.experiments.running.preflight import PlannedSession, check_markers
from slipscale.experiments.session.marker_outputs import open_markers
from slipscale.experiments.session.markers import Event, Markers
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.faults import UserError
from slipscale.hardware.errors import ConnectionLost


class Planned(UnattendedOperator):
    """An operator who asks for one thing at a given poll, goes on after a pause, and listens."""

    def __init__(self, poll=0, request=None):
        super().__init__()
        self.left, self.request = poll, request
        self.told = []

    def tell(self, status):
        super().tell(status)
        self.told.append(status.message)

    def poll(self):
        self.left -= 1
        if self.left == 0:
            return self.request
        return Request(what="go_on") if self._state == "paused" else super().poll()


class Recorder:
    """An output that keeps what it is sent; fails from a given marker on."""

    def __init__(self, name="recorder", works_for=10_000):
        self.name = name
        self.sent = []
        self.works_for = works_for
        self.closed = False

    def send(self, event, trial):
        if len(self.sent) == self.works_for:
            raise OSError("the cable is out")
        self.sent.append((event, trial))

    def close(self):
        self.closed = True


@pytest.fixture
def marked(laboratory):
    """Return a function that runs a session with recorders."""

    def run(*recorders, **options):
        return laboratory.run(markers=Markers(recorders), **options)

    return run


def test_each_trial_has_its_onset_settling_and_answer_in_that_order(marked, laboratory):
    recorder = Recorder()
    marked(recorder)
    assert recorder.sent[0] == (Event.BEGIN, None)
    assert recorder.sent[-1] == (Event.END, None)
    main = [
        record.data["what"]
        for record in laboratory.records(kind="begin")
        if record.data["what"]["type"] in ("Present", "Ask") and record.data["what"]["trial"]
    ]
    expected = []
    for step in main:
        trial = step["trial"]["number"]
        if step["type"] == "Present":
            expected += [(Event.ONSET, trial), (Event.SETTLED, trial)]
        else:
            expected.append((Event.ANSWER, trial))
    assert [sent for sent in recorder.sent if sent[1] is not None] == expected
    assert len(expected) > 30


def test_markers_change_nothing_in_the_journal_but_the_record_of_their_own(marked, laboratory):
    def after_the_header():
        told = ((record.kind, dict(record.data)) for record in laboratory.records()[1:])
        return [(kind, data | {"kept": 0}) for kind, data in told]  # numbers shift by one

    laboratory.run()
    plain = after_the_header()
    laboratory.folder /= "with"
    marked(Recorder())
    found = after_the_header()
    assert found[0] == ("markers", {"outputs": ["recorder"], "kept": 0})
    assert found[1:] == plain


def test_a_fault_and_the_new_presentation_are_marked(marked, laboratory, monkeypatch):
    recorder = Recorder()

    def feel_once_in_vain(plan):
        person = laboratory.simulated(plan)
        perform, failed = person.perform, []

        def fail_once(step, watch):
            if step.trial and step.trial.number == 3 and not failed:
                failed.append(step)
                raise ConnectionLost("the line is dead")
            return perform(step, watch)

        monkeypatch.setattr(person, "perform", fail_once)
        return person

    assert marked(recorder, person=feel_once_in_vain) == "complete"
    at = [event for event, _ in recorder.sent].index(Event.FAULT)
    assert [event for event, _ in recorder.sent[at + 1 : at + 3]] == [Event.ONSET, Event.SETTLED]


def test_a_pause_is_marked(marked):
    recorder = Recorder()
    marked(recorder, operator=Planned(30, Request(what="pause")))
    assert [event for event, _ in recorder.sent].count(Event.PAUSE) == 1


def test_an_output_that_fails_is_told_written_down_and_left_out_and_the_session_goes_on(
    marked, laboratory
):
    bad, good = Recorder("bad", works_for=10), Recorder("good")
    operator = Planned()
    assert marked(bad, good, operator=operator) == "complete"
    assert bad.closed
    assert len(good.sent) > 40
    first, lost = laboratory.records(kind="markers")
    assert first.data == {"outputs": ["bad", "good"]}
    assert lost.data == {"outputs": ["good"], "lost": "bad", "reason": "the cable is out"}
    assert last_markers(laboratory.records()) == ("good",)
    told = [message for message in operator.told if "NO MORE MARKERS" in message]
    assert told == ["NO MORE MARKERS on bad: the cable is out"]


def test_the_codes_are_one_wire_each():
    assert [event.bit_count() for event in Event] == [1] * len(Event)
    assert max(Event) < 256


@pytest.fixture
def line():
    """Return a pseudo-terminal: the path to open, and the descriptor at which to listen."""
    far, near = os.openpty()
    tty.setraw(near)
    yield os.ttyname(near), far
    os.close(far)
    os.close(near)


def test_a_serial_box_gets_a_pulse_for_each_event_and_is_left_at_zero(line):
    path, far = line
    with open_markers([f"serial:{path}"]) as markers:
        for event in (Event.ONSET, Event.SETTLED, Event.ANSWER):
            markers.mark(event)
    got = b""
    while len(got) < 7:
        got += os.read(far, 100)
    assert list(got) == [2, 0, 4, 0, 8, 0, 0]


def test_lab_streaming_layer_leaves_the_operators_terminal_alone():
    """Its library writes by itself: only a process of its own shows that."""
    pytest.importorskip("pylsl")
    code = (
        "from slipscale.experiments.session.marker_outputs import open_markers\n"
        "with open_markers(['lsl:quiet']): pass"
    )
    words = [sys.executable, "-c", code]
    ended = subprocess.run(words, check=False, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", "")


def test_a_receiver_of_lab_streaming_layer_gets_event_and_trial(laboratory):
    pylsl = pytest.importorskip("pylsl")
    name = f"Slipscale-test-{os.getpid()}"
    with open_markers([f"lsl:{name}"]) as markers:
        (found,) = pylsl.resolve_byprop("name", name, timeout=300)
        assert (found.type(), found.channel_count()) == ("Markers", 2)
        inlet = pylsl.StreamInlet(found)
        inlet.open_stream(300)
        laboratory.run(markers=markers)
        got, times = [], []
        while not got or got[-1][0] != "end":
            sample, time_s = inlet.pull_sample(timeout=300)
            assert sample is not None
            got.append(sample)
            times.append(time_s)
    assert got[0] == ["begin", ""]
    assert ["settled", "1"] in got
    assert times == sorted(times)


def test_a_parallel_port_is_set_and_cleared(monkeypatch):
    seen = []

    class Port:
        def __init__(self, address):
            seen.append(address)

        def setData(self, data):
            seen.append(data)

    monkeypatch.setitem(sys.modules, "psychopy.parallel", types.SimpleNamespace(ParallelPort=Port))
    with open_markers(["parallel:0x378"]) as markers:
        markers.mark(Event.FAULT)
    assert seen == [0x378, 0, 16, 0, 0]


@pytest.mark.parametrize(
    "specs, told",
    [
        (["nirs"], "expected lsl, lsl:NAME, serial:PORT or parallel:ADDRESS"),
        (["serial"], "expected lsl, lsl:NAME, serial:PORT or parallel:ADDRESS"),
        (["serial:/dev/no-such-port"], "cannot be opened"),
        (["parallel:/dev/no-such-port"], "cannot be opened"),
        (["lsl:a", "lsl:a"], "more than once"),
    ],
)
def test_what_cannot_be_opened_is_one_sentence(specs, told):
    with pytest.raises(UserError, match=told), open_markers(specs):
        pass


def test_without_pylsl_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(UserError, match=r"slipscale\[markers\]"), open_markers(["lsl"]):
        pass


def test_check_sends_on_each_output(line, tmp_path):
    path, far = line
    planned = PlannedSession(
        study="biet2007", plate="mock", out=tmp_path, markers=(f"serial:{path}",)
    )
    finding = check_markers(planned)
    assert finding.passed
    assert path in finding.detail
    got = b""
    while len(got) < 5:
        got += os.read(far, 100)
    assert list(got) == [1, 0, 64, 0, 0]


def test_a_resumed_run_goes_on_with_the_markers_it_had(marked, laboratory, plan, monkeypatch):
    recorder = Recorder("lsl:EEG")
    marked(recorder, operator=Planned(40, Request(what="stop")))
    settings = []
    monkeypatch.setattr(
        "slipscale.experiments.running.lab_session.go_on",
        lambda _path, setting: settings.append(setting) or "complete",
    )
    monkeypatch.setattr(
        "slipscale.experiments.journal.plan_and_progress.answered_by", lambda _records: "person"
    )
    path = plan().journal_path(laboratory.folder)
    parser, resume = commands.load_command("resume")
    resume(parser.parse_args([str(path), "--windowed"]))
    assert settings[0].markers == ("lsl:EEG",)
