"""Every fault in every phase of a trial: a whole session over the emulated board, byte for byte.

Board and driver run in virtual time. The session has its own clock, so no pause of a study is
waited for.

The participant answers with ten times the amplitude that the emulated plate truly vibrates with
at that moment: an estimate that does not fit its row was given to another surface.
"""

import re
from dataclasses import replace

import pytest

from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.running.preflight import CHECKS, PlannedSession
from slipscale.experiments.steps.steps import Ask, Explore
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import PlateFault
from tests.support.board_sessions import (
    STUDY,
    TEXTURED,
    PatientOperator,
    board_plan,
    due,
    felt,
    rows_of,
    run_on_board,
)
from tests.support.scripted import ScriptedParticipant

SEED_TEXTURED = 8  # the trial with the fault presents the ridges
LARGEST = {"n/a": [0.5, 1.2, 2.3], "ridges": [1.8], "waves": [1.8]}

BACK_S = 0.1
OPTIONS = ("--back-after", str(BACK_S), "--noise", "0")
FAULTY_TRIAL = 2

ENDING = ["unplug", "unplug_mid_read", "reset", "reset_after", "busy", "hot", "deaf", "trickle"]
REPAIRED = [
    "drop",
    "garbage_before",
    "garbage_inside",
    "garbage_after",
    "garbage_line",
    "truncated",
    "delayed",
    "duplicated",
    "out_of_order",
]
PLAYING = [(fault, phase) for fault in ENDING for phase in ("starting", "exploring", "answering")]
PLAYING += [(fault, "starting") for fault in REPAIRED] + [("delayed", "reconnecting")]
PHASES = ["presenting", "reading", "exploring", "answering", "silencing", "reconnecting"]


@pytest.fixture
def board(host):
    return host.plug_in(*OPTIONS)


@pytest.fixture
def compiled_board(host):
    return host.plug_in(*OPTIONS, "--firmware")


class Participant(ScriptedParticipant):
    """Answers what the plate truly does, and orders faults for its second trial."""

    def __init__(self, board, fault, phase, clock):
        super().__init__(lambda _: felt(board), clock, step_s=0.01)
        self.board, self.fault, self.phase = board, fault, phase
        self.ends = fault in ENDING
        self.given = []

    def fail_at(self, step):
        trial = step.trial.number if getattr(step, "trial", None) else 0
        before = isinstance(step, Ask) and trial == FAULTY_TRIAL - 1
        during = trial == FAULTY_TRIAL
        orders = {
            "presenting": (before, f"{self.fault}@present"),
            "starting": (before, f"{self.fault}@play/2"),
            "reading": (before, f"{self.fault}@read"),
            "exploring": (during and isinstance(step, Explore), self.fault),
            "answering": (during and isinstance(step, Ask), self.fault),
            "silencing": (during and isinstance(step, Ask), f"{self.fault}@silence"),
            "reconnecting": (during and isinstance(step, Ask), f"unplug+{self.fault}@connect/1"),
        }
        due, order = orders[self.phase]
        if due and self.fault:
            self.board.fault(order)
            self.fault = None
            return self.phase in ("exploring", "answering", "reconnecting")
        return False

    def perform(self, step, watch):
        if self.fail_at(step):
            # A few heartbeats; what ends the trial comes up by then, and sooner.
            host = self.board.host
            end_s = host.now() + (2.0 if self.ends else 0.25)
            while host.now() < end_s:
                watch()
                host.sleep(0.005)
        reply = super().perform(step, watch)
        if isinstance(step, Ask):
            self.given.append(reply.value)
        return reply


def run_session(board, fault, phase, folder, *, study=STUDY, seed=1, **plates):
    plan, clock = board_plan(study, seed=seed), VirtualClock()
    person = Participant(board, fault, phase, clock)
    operator = PatientOperator(BACK_S, board.host)
    outcome = run_on_board(board, plan, folder, person, clock, operator=operator, **plates)
    return outcome, person, read_plan(plan.journal_path(folder))[1], rows_of(folder)


PAIRED = STUDY.replace(
    "[[tasks]]",
    """[second_plate]
quantity = {}
amplitude_um_pp = 2.0

[[factors]]
name = "second_amplitude_um_pp"
levels = [0.7, 1.5]

[[tasks]]""",
).replace("[0.5, 1.2, 2.3]", "[0.5, 1.2]")


def test_a_board_that_is_the_second_actuator_fails_and_comes_back(board, tmp_path):
    outcome, person, records, rows = run_session(
        board, "unplug", "exploring", tmp_path, study=PAIRED, first="mock"
    )
    assert (outcome, person.fault) == ("complete", None)
    assert [r.data["code"] for r in records if r.kind == "fault"] == ["lost"]
    assert [row["flag"] for row in rows] == ["n/a", "fault;represented", "n/a", "n/a"]
    for row in rows:
        second = float(row["second_amplitude_um_pp"])
        assert float(row["estimate"]) == pytest.approx(10 * second, abs=0.1)
        readback = float(row["second_readback_um_pp"])
        assert readback == pytest.approx(second, abs=0.05)
    assert not board.state()["vibrates"]


def check_data(board, person, records, rows):
    """Nothing is lost, nothing belongs to another surface, the plate is silent."""
    for texture in {row["texture"] for row in rows}:
        presented = [row["amplitude_um_pp"] for row in rows if row["texture"] == texture]
        assert sorted(map(float, presented)) == LARGEST[texture]
    for row in rows:
        estimate, mean_level = due(row["texture"], float(row["amplitude_um_pp"]))
        assert float(row["estimate"]) == pytest.approx(estimate, abs=0.1)
        readback = float(row["amplitude_readback_um_pp"])
        assert readback == pytest.approx(mean_level, abs=0.05)
    assert records[-1].kind == "end"
    kept = [r for r in records if r.kind in ("done", "discarded")]
    answers = [r.data["answer"] for r in kept if (r.data["answer"] or {}).get("value") is not None]
    assert [answer["value"] for answer in answers] == person.given
    assert not board.state()["vibrates"]


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("fault", ENDING)
def test_a_fault_in_the_middle_ends_in_complete_and_flagged_data(board, tmp_path, fault, phase):
    outcome, person, records, rows = run_session(board, fault, phase, tmp_path)
    assert outcome == "complete"
    assert person.fault is None
    check_data(board, person, records, rows)
    told = [r for r in records if r.kind == "fault"]
    if not told:
        # A hot board obeys a silence.
        assert (fault, phase) == ("hot", "silencing")
        return
    flagged = [row["trial"] for row in rows if row["flag"] != "n/a"]
    assert flagged, [r.data for r in told]
    assert set(flagged) <= {str(FAULTY_TRIAL - 1), str(FAULTY_TRIAL), str(FAULTY_TRIAL + 1)}


@pytest.mark.parametrize("phase", ["presenting", "reading", "exploring", "silencing"])
@pytest.mark.parametrize("fault", REPAIRED)
def test_a_spoiled_answer_goes_unnoticed(board, tmp_path, fault, phase):
    outcome, person, records, rows = run_session(board, fault, phase, tmp_path)
    assert outcome == "complete"
    check_data(board, person, records, rows)
    assert not [r for r in records if r.kind == "fault"]


@pytest.mark.parametrize("fault, phase", PLAYING)
def test_a_fault_in_the_middle_of_a_texture_costs_no_answer(board, tmp_path, fault, phase):
    outcome, person, records, rows = run_session(
        board, fault, phase, tmp_path, study=TEXTURED, seed=SEED_TEXTURED
    )
    assert outcome == "complete"
    assert person.fault is None
    assert {"ridges", "waves", "n/a"} == {row["texture"] for row in rows}
    assert len(rows) == 5
    check_data(board, person, records, rows)
    struck = {row["texture"] for row in rows if row["trial"] == str(FAULTY_TRIAL)}
    told = [r.data["code"] for r in records if r.kind == "fault"]
    ends = fault in ENDING or phase == "reconnecting"
    assert bool(told) == ends, told
    if ends:
        assert any(row["flag"] != "n/a" for row in rows)
    else:
        assert struck == {"ridges"}


ON_FIRMWARE = [
    *(
        (fault, phase)
        for fault in ENDING
        if fault != "busy"
        for phase in ("presenting", "exploring")
    ),
    *((fault, "presenting") for fault in REPAIRED),
]


@pytest.mark.parametrize("fault, phase", ON_FIRMWARE)
def test_a_fault_on_the_compiled_firmware_costs_no_answer(compiled_board, tmp_path, fault, phase):
    outcome, person, records, rows = run_session(compiled_board, fault, phase, tmp_path)
    assert outcome == "complete"
    assert person.fault is None
    check_data(compiled_board, person, records, rows)
    assert bool([r for r in records if r.kind == "fault"]) == (fault in ENDING)


def test_a_board_that_never_comes_back_stops_the_session_resumable(host, tmp_path):
    board = host.plug_in("--back-after", "0", "--noise", "0")
    with pytest.raises(PlateFault):
        run_session(board, "unplug", "answering", tmp_path)
    assert not board.state()["vibrates"]
    (path,) = tmp_path.glob("sourcedata/sub-01/**/*_journal.jsonl")
    records = read_plan(path)[1]
    assert records[-1].kind == "stop"
    assert next(r.data["code"] for r in records if r.kind == "fault") == "lost"


def test_the_check_before_a_session_tells_of_the_plate_and_leaves_it_silent(board, tmp_path):
    planned = PlannedSession(study="biet2007", plate=f"serial:{board.port}", out=tmp_path)
    finding = CHECKS["plate"](planned)
    assert finding.passed
    assert "slipscale-plate-1 EMULATED-1" in finding.detail
    assert "; plays textures" in finding.detail
    assert not board.state()["vibrates"]


def test_the_check_tells_that_a_board_with_older_firmware_plays_no_textures(host, tmp_path):
    board = host.plug_in("--fault", "old_firmware")
    planned = PlannedSession(study="biet2007", plate=f"serial:{board.port}", out=tmp_path)
    assert "; plays no textures" in CHECKS["plate"](planned).detail
    with pytest.raises(
        UserError, match=r"'T1': the board's firmware \(1\.0\) can only hold a constant ampl"
    ):
        CHECKS["plate"](replace(planned, study="textures_demo"))


@pytest.mark.parametrize(
    "plate, said",
    [
        ("serial:/dev/ttyNONE", "no such port. Check the cable"),
        ("serial:", "expected serial:PORT"),
        ("scpi:TCPIP0::127.0.0.1::9::SOCKET,calibration=none.toml", "No such file"),
    ],
)
def test_a_plate_that_is_not_in_order_is_a_finding_with_its_remedy(tmp_path, plate, said):
    planned = PlannedSession(study="biet2007", plate=plate, out=tmp_path)
    with pytest.raises((PlateFault, UserError), match=re.escape(said)):
        CHECKS["plate"](planned)
