"""A small laboratory: whole sessions on a mock plate in virtual time."""

import errno
import json
import os
import threading
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.keeper import Keeper
from slipscale.experiments.journal.plan_and_progress import elapsed_s, read_plan
from slipscale.experiments.participants.simulated_people.in_session import SimulatedParticipant
from slipscale.experiments.participants.simulated_people.population import Population
from slipscale.experiments.participants.simulated_people.respondent import respondent_of
from slipscale.experiments.running.begin_or_resume import plate_for, run_plan
from slipscale.experiments.session.operator import UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.sound.question_sounds import ImaginedSounds
from slipscale.experiments.study.file import study_text
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.hardware.clock import VirtualClock

# Also where a place of the same kind is tried already; minutes.
EVERY_PLACE = "SLIPSCALE_EVERY_PLACE" in os.environ


@pytest.fixture(scope="session")
def stride():
    """Return the distance between two polls, or commands, at which a run is interrupted."""
    return 1 if EVERY_PLACE else 9


@pytest.fixture(scope="session")
def places():
    """Return a function from a journal to the numbers of lines after which it is to be cut.

    One place of every kind, or each. Kinds of places differ in the records before and after them,
    and in their steps and tasks.
    """
    return _places


def _places(journal):
    kinds = []
    step: tuple[object, ...] = ()
    for record in map(json.loads, journal):
        if record["kind"] == "begin":
            what = record["what"]
            step = (what["type"], what.get("name"), (what.get("trial") or {}).get("task"))
        kinds.append((record["kind"], step))
    last = {(kinds[cut - 1], kinds[cut]): cut for cut in range(1, len(kinds))}
    return range(1, len(kinds)) if EVERY_PLACE else last.values()


def make_plan(text=None, **changes):
    return RunPlan(
        **{
            "study_name": "biet2007",
            "study_text": text or study_text("biet2007"),
            "participant": "01",
            "seed": 2007,
            "language": "en",
            "mode": "pilot",
            "population": Population().model_dump_json(),
        }
        | changes
    )


@dataclass
class Laboratory:
    """Runs plans and keeps what tests look at: the plate and the participant of the last run."""

    folder: Path
    spec: str = "mock"
    plate: object = None
    person: object = None
    clock: VirtualClock = field(default_factory=VirtualClock)

    def run(self, plan=None, *, person=None, operator=None, spec=None, unblind=False, **heard):
        """Begin the plan's run, or go on with it where its journal exists.

        ``heard`` holds the masking noise, the sounds and the markers.
        """
        plan = plan or make_plan()
        path = plan.journal_path(self.folder)
        if path.exists():
            self.clock = VirtualClock(elapsed_s(read_plan(path)[1]))
            journal = Journal.reopen(path, self.clock)
        else:
            self.clock = VirtualClock()
            journal = Journal.create(path, self.clock)
        self.plate = plate_for(plan, spec or self.spec, self.clock)
        with journal, self.plate:
            self.person = (person or self.simulated)(plan)
            simulated = isinstance(self.person, SimulatedParticipant)
            return run_plan(
                plan,
                Setup(
                    plate=self.plate,
                    participant=self.person,
                    journal=journal,
                    clock=self.clock,
                    operator=operator or UnattendedOperator(),
                    unblind=unblind,
                    **({"sounds": ImaginedSounds()} | heard),
                ),
                spec=spec or self.spec,
                steps=self.person.attend(plan.steps()) if simulated else None,
            )

    def simulated(self, plan):
        return SimulatedParticipant(
            respondent_of(plan), feel=self.plate.vibration_level, clock=self.clock
        )

    def records(self, plan=None, kind=None):
        records = read_plan((plan or make_plan()).journal_path(self.folder))[1]
        return [record for record in records if kind is None or record.kind == kind]


class SlowDisk:
    """Is busy until it is waited for, notes what it has, and fails at one of its waits."""

    def __init__(self):
        self.kept = b""
        self.waits = 0
        self.fails_at = None
        self.free = threading.Event()
        self.free.set()

    def fsync(self, descriptor):
        self.waits += 1
        if self.waits == self.fails_at:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        written = Path(f"/proc/self/fd/{descriptor}")
        content = written.read_bytes() if written.is_file() else self.kept
        self.free.wait()
        self.kept = content


@pytest.fixture
def slow_disk(monkeypatch):
    disk = SlowDisk()
    wait = Keeper.wait
    monkeypatch.setattr(os, "fsync", disk.fsync)
    monkeypatch.setattr(Keeper, "wait", lambda *words: disk.free.set() or wait(*words))
    return disk


@pytest.fixture
def laboratory(tmp_path):
    return Laboratory(tmp_path)


@pytest.fixture(scope="session")
def plan():
    return make_plan


@pytest.fixture(scope="session")
def record_runs():
    """Return a function that records whole runs in a folder, for tests that share them."""

    def record(folder, *participants, **changes):
        for participant in participants:
            Laboratory(folder).run(make_plan(participant=participant, **changes))
        return folder

    return record
