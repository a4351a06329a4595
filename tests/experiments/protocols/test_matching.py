"""Matching: where catch trials begin, and the reference felt again while the plate is turned."""

import pytest

from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.protocol_parts.simulated_answers import misfit
from slipscale.experiments.protocols.matching import Matching
from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.steps.replies import FEEL_AGAIN, Reply
from slipscale.experiments.steps.steps import Adjust, Explore, Present
from slipscale.experiments.steps.trial import Trial
from slipscale.experiments.study.file import study_text
from tests.support.scripted import ScriptedParticipant

STUDY = (
    study_text("matching")
    .replace("repetitions = 3", "repetitions = 1")
    .replace("practice = 2", "practice = 0")
    .replace("catch_trials = 2", "catch_trials = 0")
    .replace("[0.8, 1.2, 1.6]", "[1.2]")
)


class Patient(ScriptedParticipant):
    """Takes a second to press any key of an adjustment, and notes the limits that are left."""

    def adjust(self, step, turn, watch, *, again=0):
        reply = super().adjust(step, turn, watch, again=again)
        self._clock.sleep(1.0)
        took_s = self._clock.now() - reply.onset_s
        return Reply(value=reply.value, onset_s=reply.onset_s, response_time_s=took_s)


@pytest.fixture
def matched(laboratory, plan):
    """Return a function that has a script turn: the rows, the person, the records."""

    def run(*script, text=STUDY):
        made = plan(text, seed=3)
        laboratory.run(made, person=lambda _: Patient(script, laboratory.clock))
        ((protocol, _),) = made.tasks()
        trials = gather(read_plan(made.journal_path(laboratory.folder))[1]).trials["matching"]
        rows = [
            {name: column.value(trial) for name, column in columns(protocol).items()}
            for trial in trials
        ]
        return rows, laboratory.person, laboratory.records(made)

    return run


def test_a_catch_trial_begins_at_its_reference_and_says_so(plan):
    made = plan(STUDY.replace("catch_trials = 0", "catch_trials = 5"), seed=3)
    begun = {}
    for step in dry_run(made):
        if isinstance(step, Present):
            begun.setdefault(step.trial.number, [step.trial.factors["direction"]]).append(
                step.surface.level
            )
    equal = [number for number, (direction, *_) in begun.items() if direction == "equal"]
    assert len(begun) == made.planned_trials() == 7
    assert len(equal) == 5
    assert equal != [3, 4, 5, 6, 7]  # among the others, not after them
    for number, (_, reference, start) in begun.items():
        assert (start == reference) == (number in equal)


def test_catch_trials_leave_the_matches_as_they_are_without(plan):
    def starts(text):
        return [
            step.surface.level
            for step in dry_run(plan(text, seed=3))
            if isinstance(step, Present)
            and step.interval == 2
            and step.trial.factors["direction"] != "equal"
        ]

    assert starts(STUDY) == starts(STUDY.replace("catch_trials = 0", "catch_trials = 5"))


def test_the_reference_is_felt_again_and_the_turning_goes_on_where_it_was(matched):
    rows, person, records = matched(3, FEEL_AGAIN, FEEL_AGAIN, -1, 2)
    # The first match is over with its first answer; the second asks twice before it turns.
    assert [row["felt_again"] for row in rows] == [0.0, 2.0]
    assert rows[1]["turns"] == 1.0
    assert rows[1]["matched_um_pp"] == pytest.approx(rows[1]["interval2_amplitude_um_pp"] - 0.02)
    made = [record.data for record in records if record.kind == "felt_again"]
    assert [(each["trial"], each["answer"]["commanded_level"]) for each in made] == [(2, 1.2)] * 2
    explored = [
        step for step in person.seen if isinstance(step, Explore) and step.trial.number == 2
    ]
    assert [step.interval for step in explored] == [1, 1, 1]


def test_feeling_again_takes_no_turning_time_and_is_part_of_the_response_time(matched):
    rows, person, _ = matched(1, FEEL_AGAIN, 1)
    first, second, third = person.turned
    assert first.time_limit_s == second.time_limit_s == 90.0
    assert third.time_limit_s == 89.0  # a second went by until the key
    # A second until the key, one of stroking, one notch, one until the last key; and the plate.
    assert rows[1]["response_time"] > rows[0]["response_time"] + 2
    assert rows[1]["flag"] is None


def test_what_a_person_cannot_feel_again_is_no_answer(matched):
    rows, person, _ = matched(
        2, 1, text=STUDY.replace("reference_again = true", "reference_again = false")
    )
    assert [row["felt_again"] for row in rows] == [0.0, 0.0]
    assert all(step.again is None for step in person.turned)


def adjust(again):
    trial = Trial(task="matching", number=1, total=1)
    return Adjust(
        name="matched_um_pp",
        text="turn",
        trial=trial,
        interval=2,
        step_level=0.02,
        lowest_level=0.0,
        highest_level=2.3,
        again=again,
    )


def test_a_simulated_person_asks_only_for_what_can_be_felt():
    offered = (Present(surface=None), Explore(text="stroke"))
    assert misfit(adjust(offered), FEEL_AGAIN) is None
    assert "expected a whole number of notches" in misfit(adjust(None), FEEL_AGAIN)


def test_simulated_people_feel_the_reference_again_in_some_of_their_matches(laboratory, plan):
    made = plan(STUDY.replace("repetitions = 1", "repetitions = 4"), seed=3)
    laboratory.run(made)
    asked = {record.data["trial"] for record in laboratory.records(made, kind="felt_again")}
    assert 0 < len(asked) < made.planned_trials()


def test_catch_trials_are_off_where_a_study_does_not_ask_for_them():
    options = Matching(protocol="matching")
    assert (options.catch_trials, options.reference_again) == (0, False)
