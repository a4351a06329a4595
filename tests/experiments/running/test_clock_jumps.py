"""The computer's date is set forward and back, in a session and between two: nothing follows it."""

import time
from datetime import UTC, datetime, timedelta

import pandas as pd
import pytest

from slipscale.experiments.dataset.measured import OF_THE_PLATE, SECOND_READBACK
from slipscale.experiments.journal import header
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.journal.record import decode, sealed
from slipscale.experiments.participants.base import StopRequested
from slipscale.experiments.running import lab_session
from slipscale.experiments.running.lab_session import Setting, begin, go_on, make_plan
from slipscale.experiments.steps.questions.number import NumberQuestion
from slipscale.experiments.steps.questions.text import TextQuestion
from slipscale.experiments.steps.questions.yes_no import YesNoQuestion
from slipscale.hardware.clock import VirtualClock
from tests.support.scripted import ScriptedParticipant

DAY = timedelta(days=1)


class PersonsClock:
    """Moves only when told to, and yet is no pilot's."""

    def __init__(self, start_s=0.0):
        self._clock = VirtualClock(start_s)
        self.now, self.sleep = self._clock.now, self._clock.sleep
        self.suspended_s = self._clock.suspended_s


class Wall:
    """The computer's date, which anybody can set."""

    def __init__(self):
        self.date = datetime(2026, 3, 1, 12, tzinfo=UTC)

    def now(self, zone):
        return self.date.astimezone(zone)

    def timestamp(self):
        return self.date.timestamp()

    fromisoformat = staticmethod(datetime.fromisoformat)


@pytest.fixture
def wall(monkeypatch):
    wall = Wall()
    monkeypatch.setattr(header, "datetime", wall)
    monkeypatch.setattr(lab_session, "datetime", wall)
    monkeypatch.setattr(lab_session, "SystemClock", PersonsClock)
    monkeypatch.setattr(lab_session, "check_device", lambda: "no headphones")
    monkeypatch.setattr(time, "time", wall.timestamp)
    return wall


@pytest.fixture
def session(monkeypatch, tmp_path, wall):
    """Return a function that runs one session: what jumps at each answer, and stops after some."""

    def run(folder, jump=timedelta(), stop_after=None):
        given = []

        def answer(ask):
            wall.date += jump
            given.append(ask)
            if len(given) == stop_after:
                return StopRequested("tired")
            if isinstance(ask.question, NumberQuestion):
                return 7.0
            if isinstance(ask.question, YesNoQuestion):
                return True
            return "less" if isinstance(ask.question, TextQuestion) else "yes"

        monkeypatch.setattr(
            lab_session,
            "PsychoPyWindow",
            lambda *, clock, **_: ScriptedParticipant(answer, clock, step_s=1.5),
        )
        plan = make_plan("biet2007", participant="01", pilot=True)
        path = plan.journal_path(tmp_path / folder)
        if path.exists():
            return path, go_on(path, Setting(plate="mock"))
        return path, begin(tmp_path / folder, plan, Setting(plate="mock"))

    return run


def tables(path):
    found = sorted(path.parents[2].glob("sub-01/beh/*.tsv"))
    assert len(found) == 4  # two tasks, each with its events
    return [pd.read_csv(each, sep="\t", keep_default_na=False) for each in found]


@pytest.mark.parametrize("jump", [DAY, -DAY, 4000 * DAY], ids=["forward", "back", "eleven years"])
def test_a_date_that_jumps_in_a_session_changes_no_time(session, jump):
    still, _ = session("still")
    jumping, outcome = session("jumping", jump)
    assert outcome == "complete"
    for one, other in zip(tables(still), tables(jumping), strict=True):
        pd.testing.assert_frame_equal(one, other)


@pytest.mark.parametrize("days", [-4000, -1, 4000])
def test_a_date_that_jumps_between_two_sessions_moves_no_time_back(session, wall, days):
    whole, _ = session("whole")
    session("parted", stop_after=6)
    wall.date += days * DAY
    path, outcome = session("parted")
    assert outcome == "complete"
    records = read_plan(path)[1]
    times = [record.time_s for record in records]
    assert times == sorted(times)
    (resume,) = [record for record in records if record.kind == "resume"]
    assert resume.data["resumed_utc"] == wall.date.isoformat(timespec="seconds")
    # The interrupted trial lasts longer, and what the plate measures follows time.
    measured = [
        "amplitude_readback_um_pp",
        *(each for each in OF_THE_PLATE if each != SECOND_READBACK),
    ]
    when = ["onset", "duration", "flag", *measured]
    for one, other in zip(tables(whole), tables(path), strict=True):
        pd.testing.assert_frame_equal(
            *(each.drop(columns=when, errors="ignore") for each in (one, other))
        )


@pytest.mark.parametrize("date", ["yesterday", "2026-03-01", ""])
def test_a_run_whose_date_is_none_can_be_gone_on_with(session, date):
    path, _ = session("edited", stop_after=6)
    lines, before = [], ""
    for line in path.read_bytes().splitlines(keepends=True):
        record, _ = decode(line)
        if record.kind == "header":
            record.data["started_utc"] = date
        made, sound = sealed(record, before)
        before = made.hash
        lines.append(sound)
    path.write_bytes(b"".join(lines))
    _, outcome = session("edited")
    assert outcome == "complete"
