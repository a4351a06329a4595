"""Adaptive trials: voided and timed-out ones come again, and nobody counts wrong."""

import pytest

from slipscale.experiments.protocol_parts.adaptive.answered_tracks import AnsweredTracks
from slipscale.experiments.protocol_parts.base import Context
from slipscale.experiments.protocol_parts.building_blocks.forced_choice import (
    ForcedChoice,
    expected_trials,
    most_trials,
)
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.experiments.protocols.difference_threshold import DifferenceThreshold
from slipscale.experiments.steps.replies import Answer, Reply, Voided
from slipscale.experiments.steps.steps import Ask, EndBlock, EndTrial, Feedback, Present


class Anything(dict[str, str]):
    def __missing__(self, _key):
        return "a | b | c"


CONTEXT = Context(
    seed=1,
    participant="01",
    row=0,
    levels=(1.2,),
    texts=Anything(),
    task="differencethreshold",
)


def options(**changes):
    return DifferenceThreshold(
        **{"protocol": "difference_threshold", "most_trials": 6, "tracks": 2, "practice": 1}
        | {"catch_trials": 1, "rest_every_trials": 1000}
        | changes
    )


def play(made, answer=lambda _trial: True, voids=None, dropped=()):
    """Run a task; return its trials as their last steps have them, and the screens after blocks.

    Parameters
    ----------
    answer : callable
        Whether a trial is answered right; None for no answer.
    voids : dict
        Trials that are voided at the end of a trial, or at "screen 1", "screen 2", ...
    dropped : tuple
        Trials that are rejected at their end, and not repeated.
    """
    voids = dict(voids or {})
    run = ForcedChoice(made, CONTEXT, texts="difference_threshold.more", standard_level=1.2)
    steps, trials, screens, shown = run.steps(), [], 0, []
    step = next(steps)
    while True:
        reply: Answer = Reply()
        if isinstance(step, Ask):
            right, target = answer(step.trial), step.trial.factors["target_interval"]
            wrong = target % made.intervals + 1
            value = None if right is None else float(target if right else wrong)
            reply = Reply(value=value, timed_out=right is None)
        elif isinstance(step, EndTrial):
            trials.append(step.trial)
            rejected = tuple({step.trial.number} & {*dropped})
            reply = Voided(trials=voids.pop(step.trial.number, ()), dropped=rejected)
        elif isinstance(step, EndBlock):
            screens += 1
            reply = Voided(trials=voids.pop(f"screen {screens}", ()))
        elif isinstance(step, Feedback | Present):
            shown.append(step)
        try:
            step = steps.send(reply)
        except StopIteration:
            return trials, shown


def of_track(trials, track):
    return [t.factors["track_level"] for t in trials if t.factors["track"] == track]


def test_the_last_trial_knows_that_it_is_the_last_and_no_run_has_more_than_it_says():
    for made in (options(), options(reversals=2), options(rule="quest_plus", quest_levels=8)):
        trials, _ = play(made, lambda trial: trial.number % 3 > 0)
        assert [trial.number for trial in trials] == list(range(1, len(trials) + 1))
        assert trials[-1].total == trials[-1].number <= most_trials(made, CONTEXT)
        assert all(trial.total > trial.number for trial in trials[:-1])
        assert expected_trials(made, CONTEXT) <= most_trials(made, CONTEXT)


def test_a_trial_voided_while_it_runs_comes_again_with_its_track_and_level():
    undisturbed, _ = play(options())
    at = next(t.number for t in undisturbed if t.factors["track"]) + 2
    trials, _ = play(options(), voids={at: (at,)})
    voided, again = trials[at - 1], trials[at]
    assert again.repeats == at
    for factor in ("track", "track_level"):
        assert again.factors[factor] == voided.factors[factor]
    assert len(trials) == len(undisturbed) + 1
    assert trials[-1].total == trials[-1].number
    for track in (1, 2):
        kept = [t for t in trials if t.number != at]
        assert of_track(kept, track) == of_track(undisturbed, track)


def test_a_rejected_trial_that_is_not_repeated_does_not_move_its_track():
    made = options(tracks=1, practice=0, catch_trials=0)
    undisturbed, _ = play(made)
    trials, _ = play(made, dropped=(3,))
    assert [trial.repeats for trial in trials] == [None] * len(trials)
    assert trials[3].factors["track_level"] == trials[2].factors["track_level"]
    assert of_track([t for t in trials if t.number != 3], 1) == of_track(undisturbed, 1)


def test_an_answer_taken_back_later_is_as_if_it_had_not_been_given():
    """A wrong answer raises the level; voided at the next trial, the level falls back."""
    made = options(tracks=1, practice=0, catch_trials=0, most_trials=8)
    wrong = lambda trial: trial.number != 3  # noqa: E731
    trials, _ = play(made, wrong, voids={4: (3,)})
    undisturbed, _ = play(made)
    kept = [t for t in trials if t.number != 3]
    levels, expected = of_track(kept, 1), of_track(undisturbed, 1)
    assert levels[:2] == expected[:2]
    assert trials[4].factors["track_level"] == expected[3]
    assert levels[3:] == expected[3:]
    assert len(trials) == 9


@pytest.mark.parametrize("number", [1, 2])
def test_practice_and_main_trials_voided_at_the_screen_come_again_in_their_own_phase(number):
    made = options(catch_trials=0)
    undisturbed, _ = play(made)
    last = 1 if number == 1 else len(undisturbed)
    trials, _ = play(made, voids={f"screen {number}": (last,)})
    assert len(trials) == len(undisturbed) + 1
    again = next(trial for trial in trials if trial.repeats == last)
    assert again.phase == ("practice" if number == 1 else "main")
    assert trials[-1].total == trials[-1].number


def test_a_timed_out_trial_comes_again_until_it_is_answered():
    trials, _ = play(options(), lambda trial: None if trial.number == 6 else True)
    assert trials[6].repeats == 6
    assert trials[6].factors["track_level"] == trials[5].factors["track_level"]


def test_who_never_answers_comes_to_an_end():
    made = options()
    trials, _ = play(made, lambda _: None)
    assert len(trials) <= 2 * most_trials(made, CONTEXT)


def test_catch_trials_are_at_the_highest_level_and_move_no_track():
    some, _ = play(options(catch_trials=3))
    none, _ = play(options(catch_trials=0))
    caught = [trial for trial in some if trial.factors["catch"]]
    assert [trial.factors["track_level"] for trial in caught] == [1.0] * 3
    assert all(trial.factors["track"] is None for trial in caught)
    for track in (1, 2):
        assert of_track(some, track) == of_track(none, track)


@pytest.mark.parametrize("when, told", [("none", 0), ("practice", 1), ("always", 14)])
def test_feedback_comes_when_the_study_says(when, told):
    _, shown = play(options(feedback=when))
    assert sum(isinstance(step, Feedback) for step in shown) == told


@pytest.mark.parametrize("intervals", [2, 3])
def test_each_interval_holds_what_is_to_be_found_about_equally_often(intervals):
    made = options(intervals=intervals, most_trials=150, tracks=2, catch_trials=0)
    trials, shown = play(made)
    places = [trial.factors["target_interval"] for trial in trials]
    each = len(trials) / intervals
    for place in range(1, intervals + 1):
        # Three standard deviations of a fair draw.
        assert abs(places.count(place) - each) < 3 * (each * (1 - 1 / intervals)) ** 0.5
    presented = [step for step in shown if isinstance(step, Present)]
    for step in presented:
        level = step.trial.factors["track_level"]
        found = step.interval == step.trial.factors["target_interval"]
        expected = round(1.2 + level, 9) if found else 1.2
        assert step.surface.level == expected


@pytest.mark.parametrize("rule", ["staircase", "weighted", "quest_plus"])
def test_a_track_without_an_answer_is_that_of_the_other_answers(rule):
    made = options(rule=rule, quest_levels=12, tracks=1, most_trials=20)
    tracks = AnsweredTracks(made.begin(0.5, Stream))
    levels = []
    for trial in range(1, 9):
        levels.append(tracks.now.level)
        tracks.answer(trial, correct=trial % 3 > 0)
    tracks.take_back([2, 5])
    expected = made.begin(0.5, Stream).tracks[0]
    for trial in (1, 3, 4, 6, 7, 8):
        expected = expected.answered(correct=trial % 3 > 0, at_level=levels[trial - 1])
    assert tracks.now.level == expected.level
    assert tracks.now.tracks[0].progress == expected.progress
    assert tracks.now.tracks[0].progress.trials == 6


def test_what_repeats_a_trial_voided_later_is_of_its_own_track():
    made = options(practice=0, catch_trials=2)
    undisturbed, _ = play(made)
    for at in range(1, len(undisturbed)):
        trials, _ = play(made, voids={at + 1: (at,)})
        voided = trials[at - 1]
        again = [trial for trial in trials if trial.repeats == at]
        assert [trial.factors["track"] for trial in again] == [voided.factors["track"]]
        assert trials[-1].total == trials[-1].number == len(undisturbed) + 1
