"""Every protocol with intervals, killed at every record of its trials: the same bytes, all felt.

Each study is a shipped one, made short. A pilot of it is cut after each record and gone on with;
a person's run is paused at every moment, and loses its plate at every command.
"""

import os
import tomllib

import pytest

from experiments.dataset.rendering import render
from experiments.dataset.runs import read_runs
from experiments.participants.simulated import SimulatedParticipant
from experiments.protocols.steps import Ask, Explore
from experiments.session.operator import Request, UnattendedOperator
from experiments.study.file import study_text

# A shipped study, and what makes it short: every kind of trial once or twice.
SHORT = {
    "difference_threshold": {
        "most_trials = 30": "most_trials = 2",
        "practice = 3": "practice = 1",
        "catch_trials = 4": "catch_trials = 1",
        "rest_every_trials = 20": "rest_every_trials = 2\nresponse_time_limit_s = 2.6",
    },
}


@pytest.fixture(autouse=True)
def _no_waiting_for_the_disk(monkeypatch):
    """Hundreds of runs, and no machine loses its power in them."""
    monkeypatch.setattr(os, "fsync", lambda _descriptor: None)


def shortened(name):
    text = study_text(name)
    for long, short in SHORT[name].items():
        assert long in text
        text = text.replace(long, short)
    return text


@pytest.fixture(params=SHORT)
def short(request, plan):
    return plan(shortened(request.param), seed=3)


def tables(folder):
    """Return every table and sidecar that the journals in a folder give."""
    runs, problems = read_runs(folder)
    files, unfit = render(runs)
    assert not problems
    assert not unfit
    return {name: content for name, content in files.items() if name.suffix == ".tsv"}


def test_wherever_a_pilot_is_cut_its_tables_are_the_same_bytes(laboratory, short, tmp_path):
    laboratory.folder = tmp_path / "whole"
    assert laboratory.run(short) == "complete"
    expected = tables(laboratory.folder)
    lines = short.journal_path(laboratory.folder).read_bytes().splitlines(keepends=True)
    for kept in range(1, len(lines)):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = short.journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]))
        laboratory.run(short)
        assert tables(laboratory.folder) == expected, f"cut after record {kept - 1}"


class Feeling(SimulatedParticipant):
    """Notes for each answer which intervals this very person felt, without a break before it."""

    def __init__(self, answered, **about):
        super().__init__(**about)
        self.answered = answered
        self.felt = []

    def perform(self, step, watch):
        reply = super().perform(step, watch)
        if isinstance(step, Explore) and step.interval:
            if step.interval == 1:
                self.felt = []
            self.felt.append(step.interval)
        if isinstance(step, Ask) and step.trial:
            self.answered.append((step.trial.number, tuple(self.felt), self.felt_um_pp))
        return reply

    def hold(self, text, until):
        self.felt = ["a break"]
        super().hold(text, until)


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


@pytest.fixture
def sit_down(laboratory):
    """Return a function that runs a plan and tells what was felt before each answer."""

    def run(plan, **about):
        answered = []

        def person(plan):
            return Feeling(
                answered,
                seed=plan.seed,
                participant=plan.participant,
                feel=laboratory.plate.vibration_um_pp,
                clock=laboratory.clock,
                answers=plan.simulated_answers(),
            )

        assert laboratory.run(plan, person=person, **about) == "complete"
        return answered

    return run


def assert_all_felt(plan, answered):
    intervals = plan.tasks()[0][0].interval_columns
    for number, felt, _ in answered:
        assert felt == tuple(range(1, intervals + 1)), f"trial {number}"


def test_whenever_the_operator_pauses_all_intervals_are_felt_before_the_answer(
    laboratory, sit_down, short, tmp_path
):
    poll, paused = 1, True
    while paused:
        laboratory.folder = tmp_path / f"pause{poll}"
        answered = sit_down(short, operator=PausesAt(poll))
        assert_all_felt(short, answered)
        paused = bool(laboratory.records(short, kind="pause"))
        poll += 1
    assert poll > 30


def test_wherever_the_rig_fails_all_intervals_are_felt_before_the_answer(
    laboratory, sit_down, short, tmp_path
):
    command, failed = 2, True  # the first connects
    while failed:
        laboratory.folder = tmp_path / f"fault{command}"
        assert_all_felt(short, sit_down(short, spec=f"mock:fault=lost@{command}"))
        failed = bool(laboratory.records(short, kind="fault"))
        command += 1
    assert command > 30


def test_each_short_study_has_every_kind_of_trial(laboratory, short):
    laboratory.run(short)
    task, options = short.tasks()[0]
    assert tomllib.loads(short.study_text)["tasks"][0]["protocol"] == options.protocol
    (table,) = (text for name, text in tables(laboratory.folder).items() if task.task in str(name))
    header, *rows = (line.split("\t") for line in table.splitlines())
    phases = {row[header.index("phase")] for row in rows}
    assert phases == {"practice", "main"}
