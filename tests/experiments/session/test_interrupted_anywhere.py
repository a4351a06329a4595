"""A study with every option, interrupted everywhere: no answer differs, nothing unfelt is rated.

By default one place of every kind is tried, and every ninth poll and command; all of them with
SLIPSCALE_EVERY_PLACE=1 (minutes).
"""

import sys

import pytest

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.participants.simulated_people.in_session import SimulatedParticipant
from slipscale.experiments.participants.simulated_people.respondent import respondent_of
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.steps.steps import Ask, Explore
from slipscale.hardware.clock import VirtualClock

EVERY_OPTION = """
name = "everything"
title = "Every option"
seed = 5
participants = 4
amplitudes_um_pp = [0.0, 1.2]
task_order = "counterbalanced"
informed_consent = true
sessions = ["1", "2"]
runs = 2
visits = "same"

[[textures]]
name = "fine"
spatial_period_mm = 2.5
mean_um_pp = 1.2
depth_um_pp = 0.8
finger_speed_mm_s = 50.0

[[tasks]]
protocol = "descending_difference"
series = 1
catch_steps = 1
start_um_pp = 2.0
confidence = true
exploration_minimum_s = 0.5
exploration_maximum_s = 2.0
response_time_limit_s = 3.0
rest_minimum_s = 1.0

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 1
randomisation = "williams"
no_immediate_repeat = true
scale_top = "declared"
standard_um_pp = 2.0
modulus = 10.0
repeat_timed_out = true
rest_every_trials = 2
exploration_minimum_s = 0.5
exploration_maximum_s = 2.0
response_time_limit_s = 1.9
rest_minimum_s = 1.0

[[about_you]]
name = "handedness"
options = ["left", "right"]

[[about_you]]
name = "age_years"
minimum = 18
maximum = 99

[[questionnaires]]
name = "effort"
description = "Made up"
when = "after"
options = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "10"]
items = [{ name = "e01", prompt = "How hard was it?" }]

[keys]
numbers = "spoken"

[masking_noise]
level_db = -30.0
"""
RATED = ("estimate", "difference_felt")
# Mean and swing of what may be felt of each surface, µm peak to peak; a texture has phases.
FELT = {"S1": (0.0, 0.05), "S2": (1.2, 0.05), "S0": (2.0, 0.05), "T1": (1.2, 0.8)}


class Feeling(SimulatedParticipant):
    """Notes of each rating what was felt last, by this very person since they sat down."""

    def __init__(self, rated, **about):
        super().__init__(**about)
        self.rated = rated
        self.last = None

    def perform(self, step, watch):
        if isinstance(step, Ask) and step.name in RATED:
            rating = (step.trial.task, step.trial.number, step.name)
            self.rated.setdefault(rating, set()).add((self.last, round(self._feel(), 1)))
        reply = super().perform(step, watch)
        if isinstance(step, Explore):
            self.last = round(self.respondent.felt_level[-1], 1)
        return reply

    def hold(self, text, until):
        self.last = None  # the finger is off the plate, and the surface forgotten
        super().hold(text, until)


@pytest.fixture
def sit_down(laboratory):
    """Return a function that runs a plan and tells what was felt at each rating."""

    def run(plan, **about):
        rated = {}

        def person(plan):
            return Feeling(
                rated,
                respondent=respondent_of(plan),
                feel=laboratory.plate.vibration_level,
                clock=laboratory.clock,
            )

        assert laboratory.run(plan, person=person, **about) == "complete"
        return rated

    return run


def rows(records, plan):
    """Return all that a run's journal says of trials and person, as the tables have it."""
    gathered = gather(records)
    tables = {
        protocol.task: [
            {name: column.value(trial) for name, column in columns(protocol).items()}
            for trial in gathered.trials[protocol.task]
        ]
        for protocol, _ in plan.tasks()
    }
    asked = {task: dict(given) for task, given in gathered.run_answers.items()}
    return tables, {**gathered.person, **asked}


@pytest.fixture(params=["01", "02"], ids=["first order", "other order"])
def everything(request, plan):
    """A run of the study, in each order of its tasks."""
    return plan(EVERY_OPTION, participant=request.param, session="1", run="01")


def test_the_study_has_what_it_claims(laboratory, sit_down, everything):
    sit_down(everything)
    tables, person = rows(laboratory.records(everything), everything)
    trials = [row for table in tables.values() for row in table]
    assert person["handedness"] in ("left", "right")
    assert person["informed_consent"] == "yes"
    assert 18 <= person["age_years"] <= 99
    assert person["effort"]["e01"] in {str(number) for number in range(1, 11)}
    assert any("timed_out" in (row["flag"] or "") for row in trials)
    assert any(row["repeats"] for row in trials)
    estimates = tables["magnitudeestimation"]
    assert {row["phase"] for row in estimates} == {"practice", "main"}
    assert {row["surface"] for row in estimates} == {"S1", "S2", "T1"}
    assert all(row["scale_top"] and row["modulus"] == 10.0 for row in estimates)
    assert {row["confidence"] for row in tables["descendingdifference"]} - {None}


def test_wherever_a_run_is_cut_every_row_comes_out_the_same_and_was_felt(
    laboratory, sit_down, everything, tmp_path, places
):
    laboratory.folder = tmp_path / "whole"
    felt = sit_down(everything)
    expected = rows(laboratory.records(everything), everything)
    assert all(len(each) == 1 for each in felt.values())
    lines = everything.journal_path(laboratory.folder).read_bytes().splitlines(keepends=True)
    for kept in places(lines):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = everything.journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        again = sit_down(everything)
        assert again == {rating: felt[rating] for rating in again}, f"cut after {kept - 1}"
        found = rows(laboratory.records(everything), everything)
        assert found == expected, f"cut after record {kept - 1}"


def felt_again(records):
    """Return the trials, by task and number, whose surface was presented again in their course."""
    now, found = None, set()
    for record in records:
        if record.kind == "begin":
            now, step = record.data["what"]["trial"], record.data["what"]["type"]
        elif record.kind == "done" and step == "EndTrial":
            now = None
        elif record.kind == "represented" and now:
            found.add((now["task"], now["number"]))
    return found


def estimates_without_standard(records):
    """Return the trials with an estimate between which and the standard something interrupted."""
    due, step, found = False, {}, []
    for record in records:
        if record.kind in ("fault", "pause", "take_up"):
            due = True
        elif record.kind == "standard_again":
            due = False
        elif record.kind == "begin":
            step = record.data["what"]
        elif record.kind == "done" and step["type"] == "Explore" and step["trial"] is None:
            due = False
        elif record.kind == "done" and due and step.get("name") == "estimate":
            found.append(step["trial"]["number"])
    return found


def assert_felt_and_flagged(records, plan, rated):
    """Assert that each rating is of what was felt last, and flagged where that was felt again."""
    assert estimates_without_standard(records) == []
    tables, _ = rows(records, plan)
    trials = [(task, row) for task, table in tables.items() for row in table]
    flagged = {(task, row["trial"]) for task, row in trials if "represented" in (row["flag"] or "")}
    assert flagged == felt_again(records)
    surfaces = {(task, row["trial"]): row["surface"] for task, row in trials}
    for (task, trial, name), each in rated.items():
        # A question that was interrupted is asked twice, of the same surface each time.
        mean, swing = FELT[surfaces[task, trial]]
        assert [last for last, _ in each] == pytest.approx([mean] * len(each), abs=swing)
        if name == "difference_felt":  # an estimate is asked for once the plate is silent
            assert [now for _, now in each] == pytest.approx([mean] * len(each), abs=swing)


class PausesAt(UnattendedOperator):
    """Pauses at one poll, and goes on."""

    def __init__(self, poll):
        super().__init__()
        self.left = poll

    def poll(self):
        if self._state == "paused":
            return Request(what="go_on")
        self.left -= 1
        return Request(what="pause") if self.left == 0 else super().poll()


def test_whenever_the_operator_pauses_what_is_rated_was_felt_and_the_trial_says_so(
    laboratory, sit_down, plan, tmp_path, stride
):
    everything = plan(EVERY_OPTION, participant="01", session="1", run="01")
    laboratory.folder = tmp_path / "whole"
    felt = sit_down(everything)
    poll, paused = 1, True
    while paused:
        laboratory.folder = tmp_path / f"pause{poll}"
        again = sit_down(everything, operator=PausesAt(poll))
        records = laboratory.records(everything)
        paused = any(record.kind == "pause" for record in records)
        assert set(again) == set(felt)
        assert_felt_and_flagged(records, everything, again)
        poll += stride


def test_wherever_the_rig_fails_what_is_rated_was_felt_and_the_trial_says_so(
    laboratory, sit_down, plan, tmp_path, stride
):
    everything = plan(EVERY_OPTION, participant="01", session="1", run="01")
    command, failed = 2, True  # the first connects
    while failed:
        laboratory.folder = tmp_path / f"fault{command}"
        rated = sit_down(everything, spec=f"mock:fault=lost@{command}")
        records = laboratory.records(everything)
        failed = any(record.kind == "fault" for record in records)
        assert_felt_and_flagged(records, everything, rated)
        command += stride
    assert command > 50


class PersonsClock:
    """Moves only when told to, and yet is no pilot's: time that passes is not put back."""

    def __init__(self, start_s=0.0):
        self._clock = VirtualClock(start_s)
        self.now, self.sleep = self._clock.now, self._clock.sleep
        self.suspended_s = self._clock.suspended_s


def test_wherever_a_persons_run_is_taken_up_what_is_rated_was_felt_and_the_trial_says_so(
    laboratory, sit_down, plan, monkeypatch, places
):
    monkeypatch.setattr(sys.modules[type(laboratory).__module__], "VirtualClock", PersonsClock)
    everything = plan(EVERY_OPTION, participant="01", session="1", run="01")
    laboratory.folder /= "whole"
    sit_down(everything)
    lines = everything.journal_path(laboratory.folder).read_bytes().splitlines(keepends=True)
    for kept in places(lines):
        laboratory.folder = laboratory.folder.with_name(f"cut{kept}")
        path = everything.journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        rated = sit_down(everything)
        assert_felt_and_flagged(laboratory.records(everything), everything, rated)


def test_a_standard_counts_for_its_block_alone(laboratory, sit_down, plan):
    """Felt again once after a pause, not at each trial; and not in another task."""
    everything = plan(EVERY_OPTION, participant="01", session="1", run="01")
    sit_down(everything)
    polls = 1
    again = []
    while polls < 400:
        laboratory.folder = laboratory.folder.with_name(f"{polls}")
        sit_down(everything, operator=PausesAt(polls))
        records = laboratory.records(everything)
        made = [record for record in records if record.kind == "standard_again"]
        assert len(made) <= 1
        again += made
        polls += 20
    assert again
    assert {record.data["answer"]["commanded_level"] for record in again} == {2.0}
