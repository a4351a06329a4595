"""The headphone test in a session: passed, failed and decided, without sound, killed."""

import json

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.further_tables.headphones import headphone_result
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.session.operator import Request, UnattendedOperator
from slipscale.experiments.session.sound.question_sounds import NoSounds
from slipscale.experiments.steps.steps import Ask
from slipscale.experiments.study.file import parse_study
from slipscale.experiments.study.headphone_test import HEADPHONES
from slipscale.faults import UserError
from tests.support.scripted import ScriptedParticipant

STUDY = """name = "mine"
title = "Mine"
amplitudes_um_pp = [0.0, 1.2]

[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 1

[headphone_test]
"""
NOISE = "\n[masking_noise]\nlevel_db = -30.0\n"


class Recorder(NoSounds):
    """An output that notes what it was asked to play."""

    def __init__(self):
        super().__init__("")
        self.played = []

    def start(self, sound):
        self.played.append(sound)


class Deciding(UnattendedOperator):
    """Decides by the number of the answer, once a decision is asked for."""

    def __init__(self, *decisions):
        super().__init__()
        self.decisions = list(decisions)
        self.question = None
        self.told = []

    def tell(self, status):
        super().tell(status)
        if status.answering is not None and status.answering is not self.question:
            self.told.append(status.answering.question.prompt)
        self.question = status.answering

    def poll(self):
        if self.question is not None and self.decisions:
            return Request(what="answer", reason=self.decisions.pop(0))
        return super().poll()


class Listener(ScriptedParticipant):
    """A person who waits where the operator decides."""

    def perform(self, step, watch):
        if isinstance(step, Ask) and step.by == "operator":
            while True:
                self._clock.sleep(0.5)
                watch()
        return super().perform(step, watch)


def hearing(laboratory, *, wrong=lambda _number, _attempt: False, ears=None):
    """Return who answers each tone rightly, but where ``wrong`` says otherwise."""
    asked = []

    def answer(step):
        if step.task != HEADPHONES:
            return 30.0
        asked.append(step.name)
        attempt = asked.count("tones_1")
        if step.name.startswith("tones"):
            quiet = step.played.sound.quiet
            slip = wrong(int(step.name.removeprefix("tones_")), attempt)
            return float(step.played.sound.antiphase if slip else quiet)
        if step.name == "noise_level":
            return "comfortable"
        return (ears or {}).get(step.played.sound.ear, step.played.sound.ear)

    return lambda _: Listener(answer, laboratory.clock)


def result(laboratory):
    assert build_dataset(laboratory.folder) == []
    (path,) = laboratory.folder.glob("sub-01/beh/*.json")
    return json.loads(path.read_text())["Slipscale"]["headphone_test"]


def test_who_hears_the_quiet_tones_passes_and_the_data_say_so(laboratory, plan):
    sounds = Recorder()
    laboratory.run(plan(STUDY + NOISE), person=hearing(laboratory), sounds=sounds)
    assert result(laboratory) == {
        "result": "passed", "attempts": 1, "right": 6, "trials": 6, "needed": 5,
        "noise_left": "left", "noise_right": "right", "noise_level": "comfortable",
    }  # fmt: skip
    assert [getattr(sound, "ear", "tones") for sound in sounds.played[2:]] == [
        "both",
        *6 * ["tones"],
    ]
    assert {sound.ear for sound in sounds.played[:2]} == {"left", "right"}
    assert {sound.level_db for sound in sounds.played} == {-30.0, -20.0}


def test_without_masking_noise_there_are_tones_alone(laboratory, plan):
    sounds = Recorder()
    laboratory.run(plan(STUDY), person=hearing(laboratory), sounds=sounds)
    assert len(sounds.played) == 6
    assert "noise_left" not in result(laboratory)


def test_each_participant_hears_tones_in_an_order_of_their_own(plan):
    def orders(participant):
        steps = plan(STUDY, participant=participant).steps()
        found, answer = [], None
        for _ in range(8):
            step = steps.send(answer)
            if isinstance(step, Ask):
                found.append((step.played.sound.quiet, step.played.sound.antiphase))
        return found

    assert orders("01") == orders("01")
    assert orders("01") != orders("02")


@pytest.mark.parametrize(
    "decisions, expected",
    [
        (["2"], {"result": "passed", "attempts": 2, "right": 6}),
        (["1"], {"result": "failed", "attempts": 1, "right": 4, "decision": "go_on"}),
        (["3", "1"], {"result": "failed", "attempts": 1, "right": 4, "decision": "go_on"}),
    ],
)
def test_who_fails_is_the_operators_to_decide(laboratory, plan, decisions, expected):
    operator = Deciding(*decisions)
    person = hearing(laboratory, wrong=lambda number, attempt: attempt == 1 and number <= 2)
    assert laboratory.run(plan(STUDY), person=person, operator=operator) == "complete"
    told = result(laboratory)
    assert {key: told[key] for key in expected} == expected
    assert operator.told == ["headphone test not passed: 4 of 6 correct, 5 needed."]


def test_headphones_the_wrong_way_round_fail_however_well_the_tones_are_heard(laboratory, plan):
    operator = Deciding("1")
    person = hearing(laboratory, ears={"left": "right", "right": "left"})
    laboratory.run(plan(STUDY + NOISE), person=person, operator=operator)
    told = result(laboratory)
    assert (told["result"], told["right"], told["noise_left"]) == ("failed", 6, "right")
    assert "ear was heard elsewhere" in operator.told[0]


def test_the_operator_can_stop_instead_of_deciding(laboratory, plan):
    class Stopping(Deciding):
        def poll(self):
            return Request(what="stop", reason="no headphones") if self.question else None

    person = hearing(laboratory, wrong=lambda *_: True)
    assert laboratory.run(plan(STUDY), person=person, operator=Stopping()) == "stopped"
    (stop,) = laboratory.records(plan(STUDY), "stop")
    assert "no headphones" in stop.data["reason"]


def test_without_a_sound_output_the_test_is_left_out_with_its_reason(laboratory, plan):
    made = plan(STUDY + NOISE)
    sounds = NoSounds("no device; plug in headphones")
    assert laboratory.run(made, person=hearing(laboratory), sounds=sounds) == "complete"
    assert result(laboratory) == {
        "result": "not done",
        "reason": "no device; plug in headphones",
        "attempts": 1,
    }
    assert len(laboratory.records(made, "no_sound")) == 1


def test_simulated_people_have_headphones_on(laboratory, plan):
    for participant in range(1, 4):
        laboratory.run(plan(STUDY + NOISE, participant=f"{participant:02d}"))
    build_dataset(laboratory.folder)
    told = [
        json.loads(path.read_text())["Slipscale"]["headphone_test"]
        for path in laboratory.folder.glob("sub-*/beh/*.json")
    ]
    assert {each["result"] for each in told} == {"passed"}


def test_killed_at_each_record_of_the_test_it_ends_with_the_same_result(laboratory, plan):
    """A sound that was heard before the kill is heard again before its answer."""
    made = plan(STUDY + "trials = 2\nneeded = 1\n" + NOISE)
    laboratory.run(made)
    before = result(laboratory)
    path = made.journal_path(laboratory.folder)
    whole = path.read_bytes().splitlines(keepends=True)
    last = max(n for n, line in enumerate(whole) if b'"headphones"' in line)
    for lines in range(2, last + 2):
        path.write_bytes(b"".join(whole[:lines]))
        sounds = Recorder()
        laboratory.run(made, sounds=sounds)
        assert result(laboratory) == before
        rest = b"".join(whole[lines:]).count(b'"played":{')
        assert len(sounds.played) in (rest, rest + 1)


def test_a_test_that_is_broken_off_says_so(laboratory, plan):
    made = plan(STUDY)
    laboratory.run(made)
    path = made.journal_path(laboratory.folder)
    whole = path.read_bytes().splitlines(keepends=True)
    third = next(n for n, line in enumerate(whole) if b'"tones_3"' in line)
    path.write_bytes(b"".join(whole[:third]))
    begun, records = read_plan(path)
    told = headphone_result(records, begun.study.headphone_test)
    assert (told["result"], told["trials"]) == ("broken off", 2)


@pytest.mark.parametrize(
    "keys, told",
    [
        ("needed = 7", "expected no more than the number of trials"),
        ("level_db = 3.0", "expected 0"),
        ("trials = 0", "expected 1"),
        ("loud = 1", "unknown key"),
    ],
)
def test_what_is_wrong_with_the_test_is_told_with_its_place(keys, told):
    with pytest.raises(UserError) as fault:
        parse_study(STUDY + keys, "mine.toml")
    assert told in str(fault.value)
    assert "headphone_test" in str(fault.value)


def test_no_task_can_have_the_tests_label():
    text = STUDY.replace("practice = 0", 'practice = 0\nlabel = "headphones"')
    with pytest.raises(UserError, match=r"label of item 1 of tasks: expected another label"):
        parse_study(text, "mine.toml")
