"""Tracks that take turns, and what ends them."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.experiments.protocol_parts.adaptive.interleaved import Interleaved
from slipscale.experiments.protocol_parts.adaptive.quest_plus import QuestPlus
from slipscale.experiments.protocol_parts.adaptive.staircase import staircase
from slipscale.experiments.protocol_parts.adaptive.stopping import Stopping
from slipscale.experiments.protocol_parts.adaptive.track import Progress
from slipscale.experiments.protocol_parts.ordering.randomisation import Stream
from slipscale.faults import UserError

RULE = staircase(start_level=1, lowest_level=0.01, highest_level=2.3, steps_up=(0.2,))
QUEST = QuestPlus(levels=(0.1, 0.2, 0.4), threshold_levels=(0.1, 0.2, 0.3), slopes=(3.0,))


def stream(number):
    return Stream(2007, "01", "tracks", number)


def begun(count, stopping, order="shuffled"):
    return Interleaved.start((RULE.start(),) * count, stopping, stream, order)


@given(
    st.integers(1, 4),
    st.integers(1, 30),
    st.integers(1, 8),
    st.lists(st.booleans(), min_size=130, max_size=130),
    st.sampled_from(["alternating", "shuffled"]),
)
def test_every_block_ends_by_its_cap_with_each_track_stopped(tracks, cap, turns, answers, order):
    stopping = Stopping(most_trials=cap, reversals=min(turns, cap - 1) or None)
    block = begun(tracks, stopping, order)
    for correct in answers:
        if block.over:
            break
        block = block.answered(correct=correct)
    assert block.over
    assert block.trials <= block.most_trials == tracks * cap
    assert all(stopping.reason(track.progress) for track in block.tracks)


def test_alternating_tracks_take_turns_in_their_order():
    block = begun(3, Stopping(most_trials=2), "alternating")
    order = []
    while not block.over:
        order.append(block.current)
        block = block.answered(correct=True)
    assert order == [0, 1, 2, 0, 1, 2]


def test_each_round_of_a_shuffled_block_has_every_track_once_in_an_order_of_its_own():
    block = begun(3, Stopping(most_trials=60))
    order = []
    while not block.over:
        order.append(block.current)
        block = block.answered(correct=True)
    rounds = [tuple(order[i : i + 3]) for i in range(0, len(order), 3)]
    assert all(sorted(one) == [0, 1, 2] for one in rounds)
    assert len(Counter(rounds)) == 6


def test_a_track_that_is_over_leaves_the_others_their_turns():
    stopping = Stopping(most_trials=20, reversals=2)
    block = begun(2, stopping, "alternating")
    while not block.over:
        # Two correct and one wrong turn track 0 again and again; track 1 only ever goes down.
        correct = block.current == 1 or block.tracks[0].trials % 3 < 2
        block = block.answered(correct=correct)
    assert block.tracks[0].trials < 20
    assert block.tracks[1].trials == 20


@given(st.lists(st.booleans(), min_size=1, max_size=39), st.integers(0, 39))
def test_a_block_resumed_from_its_answers_is_the_same(answers, cut):
    whole = begun(2, Stopping(most_trials=20))
    levels = [whole.level]
    for correct in answers:
        whole = whole.answered(correct=correct)
        levels += [] if whole.over else [whole.level]
    resumed = begun(2, Stopping(most_trials=20))
    for correct in answers[:cut]:
        resumed = resumed.answered(correct=correct)
    for correct, level in zip(answers[cut:], levels[cut:], strict=False):
        assert resumed.level == level
        resumed = resumed.answered(correct=correct)
    assert resumed == whole


@pytest.mark.parametrize(
    "progress,reason",
    [
        (Progress(trials=9, reversals=6), None),
        (Progress(trials=10, reversals=5), None),
        (Progress(trials=10, reversals=6), "reversals"),
        (Progress(trials=10, threshold_sd_log10=0.05), "threshold_sd_log10"),
        (Progress(trials=10, threshold_sd_log10=0.06), None),
        (Progress(trials=40, reversals=5), "most_trials"),
    ],
)
def test_a_track_stops_for_the_first_reason_reached(progress, reason):
    stopping = Stopping(most_trials=40, least_trials=10, reversals=6, threshold_sd_log10=0.05)
    assert stopping.reason(progress) == reason


@pytest.mark.parametrize(
    "options,words",
    [
        ({"most_trials": 0}, "most_trials is 0, expected 1 to 1000"),
        ({"most_trials": 1001}, "most_trials is 1001"),
        ({"most_trials": 10, "least_trials": 11}, "expected 1 to most_trials"),
        ({"most_trials": 10, "reversals": 0}, "reversals is 0"),
        ({"most_trials": 10, "reversals": 10}, "this rule could never stop"),
        ({"most_trials": 10, "threshold_sd_log10": float("nan")}, "threshold_sd_log10 is nan"),
    ],
)
def test_a_rule_that_cannot_stop_is_refused(options, words):
    with pytest.raises(UserError, match=words):
        Stopping(**options)


def test_a_rule_that_does_not_fit_its_method_is_refused():
    with pytest.raises(
        UserError, match="no threshold_sd_log10, so this rule could never stop a track"
    ):
        Stopping(most_trials=10, threshold_sd_log10=0.05).check(RULE.start())
    with pytest.raises(UserError, match="no reversals, so this rule could never stop a track"):
        Stopping(most_trials=10, reversals=5).check(QUEST.start())
    with pytest.raises(UserError, match=r"has a spread of 0\.1\S+ before any answer"):
        Stopping(most_trials=10, threshold_sd_log10=0.5).check(QUEST.start())
    with pytest.raises(UserError, match="at least one track"):
        begun(0, Stopping(most_trials=10))
    Stopping(most_trials=10, threshold_sd_log10=0.1).check(QUEST.start())


def test_asking_a_block_that_is_over_for_a_level_is_an_error():
    block = begun(1, Stopping(most_trials=1)).answered(correct=True)
    assert block.over
    with pytest.raises(IndexError):
        _ = block.level
