"""Every protocol with intervals, killed at every record of its trials: the same bytes, all felt.

Each study is a shipped one, made short. A pilot of it is cut after a record and gone on with; a
person's run is paused at some moment, and loses its plate at some command: by default one place of
every kind, and every fifth moment and command; all of them with SLIPSCALE_EVERY_PLACE=1.
"""

import pytest

from slipscale.experiments.dataset.journals import read_runs
from slipscale.experiments.dataset.rendering import render
from slipscale.experiments.participants.simulated_people.in_session import SimulatedParticipant
from slipscale.experiments.participants.simulated_people.respondent import respondent_of
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.steps.steps import Ask, Explore
from slipscale.experiments.study.file import study_text

# A shipped study, and what makes it short: every kind of trial once or twice.
SHORT = {
    "difference_threshold": {
        "intervals = 2": "intervals = 3",
        "tracks = 2": "tracks = 1",
        "most_trials = 30": "most_trials = 2\nresponse_time_limit_s = 2.1",
        "practice = 3": "practice = 1",
        "catch_trials = 4": "catch_trials = 1",
        "rest_every_trials = 20": "rest_every_trials = 2",
    },
    "detection_threshold": {
        "most_trials = 60": "most_trials = 2",
        "practice = 3": "practice = 0",
        "catch_trials = 4": "catch_trials = 0",
    },
    "constant_stimuli": {
        "comparisons_um_pp = [1.23, 1.26, 1.32, 1.4, 1.6]": "comparisons_um_pp = [1.6]",
        '"forced_choice"': '"yes_no"',
        "repetitions = 20": "repetitions = 1",
        "practice = 3": "practice = 0",
        "catch_trials = 4": "catch_trials = 1",
    },
    "paired_comparison": {
        "[1.0, 1.06, 1.12, 1.18, 1.24]": "[1.0, 1.12, 1.24]",
        "repetitions = 2": "repetitions = 1",
        "practice = 2": "practice = 0",
        "catch_trials = 2": "catch_trials = 0",
        'label = "pairs"\nform = "pairs"': 'label = "pairs"\nform = "triads"',
    },
    "matching": {
        "[0.8, 1.2, 1.6]": "[1.2]",
        "repetitions = 3": "repetitions = 1",
        "practice = 2": "practice = 0",
        "catch_trials = 2": "catch_trials = 1",
        "step_um_pp = 0.02": "step_um_pp = 0.2",
    },
    "visual_analogue_scale": {
        "[0.0, 0.5, 1.2, 2.3]": "[0.5, 2.3]",
        "repetitions = 3": "repetitions = 1\nrest_every_trials = 2",
        "practice = 1": "practice = 1\nresponse_time_limit_s = 2.5",
        "catch_trials = 2": "catch_trials = 1",
    },
    "ratio_to_standard": {
        "[0.3, 0.6, 1.8, 2.3]": "[0.6, 2.3]",
        "repetitions = 3": "repetitions = 1",
        "practice = 1": "practice = 0",
        "catch_trials = 2": "catch_trials = 1",
        "standard_every_trials = 1": "standard_every_trials = 2",
    },
    "magnitude_production": {
        "[7.0, 10.0, 14.0, 20.0]": "[7.0, 14.0]",
        "repetitions = 2": "repetitions = 1",
        "step_um_pp = 0.05": "step_um_pp = 0.3",
        "catch_trials = 1": "catch_trials = 0",
        "[0.5, 0.8, 1.2, 1.8]": "[0.5, 1.8]",
        "repetitions = 3": "repetitions = 1",
        "practice = 1": "practice = 0",
    },
    "vezzoli2015": {  # two actuators
        "[0.6, 1.0, 1.5, 2.3]": "[0.6, 2.3]",
        "repetitions = 2": "repetitions = 1\npractice = 0",
    },
}
# Those that are paused and lose their plate as well: a choice of three, and an adjustment.
DISTURBED = ("difference_threshold", "matching")


def shortened(name):
    text = study_text(name)
    for long, short in SHORT[name].items():
        assert long in text
        text = text.replace(long, short)
    return text


@pytest.fixture(params=SHORT)
def short(request, plan):
    return plan(shortened(request.param), seed=3)


@pytest.fixture(params=DISTURBED)
def disturbed(request, plan):
    return plan(shortened(request.param), seed=3)


def tables(folder):
    """Return every table and sidecar that the journals in a folder give."""
    runs, problems = read_runs(folder)
    files, unfit = render(runs)
    assert not problems
    assert not unfit
    return {name: content for name, content in files.items() if name.suffix == ".tsv"}


def test_wherever_a_pilot_is_cut_its_tables_are_the_same_bytes(laboratory, short, tmp_path, places):
    laboratory.folder = tmp_path / "whole"
    assert laboratory.run(short) == "complete"
    expected = tables(laboratory.folder)
    lines = short.journal_path(laboratory.folder).read_bytes().splitlines(keepends=True)
    for kept in places(lines):
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
            self.answered.append((step.trial.number, tuple(self.felt)))
        return reply

    def adjust(self, step, turn, watch, *, again=0):
        reply = super().adjust(step, turn, watch, again=again)
        self.answered.append((step.trial.number, (*self.felt, step.interval)))
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
                respondent=respondent_of(plan),
                feel=laboratory.plate.vibration_level,
                clock=laboratory.clock,
            )

        assert laboratory.run(plan, person=person, **about) == "complete"
        return answered

    return run


def assert_all_felt(plan, answered):
    intervals = plan.tasks()[0][0].interval_columns
    for number, felt in answered:
        assert felt == tuple(range(1, intervals + 1)), f"trial {number}"


def test_whenever_the_operator_pauses_all_intervals_are_felt_before_the_answer(
    laboratory, sit_down, disturbed, tmp_path, stride
):
    poll, paused, turned = 1, True, []
    while paused:
        laboratory.folder = tmp_path / f"pause{poll}"
        answered = sit_down(disturbed, operator=PausesAt(poll))
        assert_all_felt(disturbed, answered)
        paused = bool(laboratory.records(disturbed, kind="pause"))
        discarded = laboratory.records(disturbed, kind="discarded")
        turned += [record.data["answer"].get("trace", []) for record in discarded]
        poll += stride
    # What was turned until a pause is kept, though it is turned again from the start.
    adjusts = disturbed.tasks()[0][0].answer == "matched_level"
    assert any(len(trace) > 1 for trace in turned) == adjusts
    assert poll > 20


def test_wherever_the_rig_fails_all_intervals_are_felt_before_the_answer(
    laboratory, sit_down, disturbed, tmp_path, stride
):
    command, failed = 2, True  # the first connects
    while failed:
        laboratory.folder = tmp_path / f"fault{command}"
        assert_all_felt(disturbed, sit_down(disturbed, spec=f"mock:fault=lost@{command}"))
        failed = bool(laboratory.records(disturbed, kind="fault"))
        command += stride
    assert command > 8


@pytest.mark.parametrize("number", [1, 2])
def test_wherever_one_of_two_actuators_fails_both_are_driven_again(
    laboratory, plan, tmp_path, number
):
    made = plan(shortened("vezzoli2015"), seed=3)
    specs = ["mock", "mock"]
    for command in (3, 8, 15):
        laboratory.folder = tmp_path / f"fault{command}"
        specs[number - 1] = f"mock:fault=lost@{command}"
        assert laboratory.run(made, spec=f"pair:{'+'.join(specs)}") == "complete"
        assert laboratory.records(made, kind="fault")
        (table,) = (
            text
            for name, text in tables(laboratory.folder).items()
            if name.name.endswith("_beh.tsv")
        )
        header, *rows = (line.split("\t") for line in table.splitlines())
        found = [dict(zip(header, row, strict=True)) for row in rows]
        assert len(found) == 4
        assert all(
            float(row["second_readback_v_peak"])
            == pytest.approx(float(row["second_voltage_v_peak"]), abs=5)
            for row in found
        )


def test_the_first_short_study_has_every_kind_of_trial(laboratory, plan):
    """Practice, catch and adaptive trials, one that timed out and comes again, three intervals."""
    made = plan(shortened("difference_threshold"), seed=3)
    laboratory.run(made)
    (table,) = (
        text for name, text in tables(laboratory.folder).items() if name.name.endswith("_beh.tsv")
    )
    header, *lines = (line.split("\t") for line in table.splitlines())
    rows = [dict(zip(header, line, strict=True)) for line in lines]
    assert {row["phase"] for row in rows} == {"practice", "main"}
    assert {row["catch"] for row in rows} == {"true", "false"}
    assert [row["repeats"] for row in rows if row["repeats"] != "n/a"]
    assert [row["trial"] for row in rows if row["flag"] == "timed_out"]
    assert all(row["interval3_amplitude_um_pp"] != "n/a" for row in rows)
