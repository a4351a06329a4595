"""The mean of the last reversals, compared with means computed by hand."""

import pandas as pd
import pytest

from slipscale.analysis.reading.trial_tables import FACTOR
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.thresholds.reversals import reversals
from slipscale.analysis.tasks.thresholds.rules import rules_of

STUDY = """
name = "levels"
title = "Levels"
amplitudes_um_pp = [1.0]
plate = {{ amplitude_um_pp = 1.5, tolerance = 0.01, tolerance_um_pp = 0.01 }}
[[tasks]]
protocol = "detection_threshold"
start_um_pp = 0.4
lowest_um_pp = 0.1
highest_um_pp = 0.8
scale = "{scale}"
steps_up = {steps}
down_after = 1
down_to_up = 1.0
"""
#: With steps of 0.1: 0.4 0.3 0.2 | 0.3 | 0.2 | 0.3 0.4 | 0.3; turns at 0.2, 0.3, 0.2, 0.4.
ANSWERS = (True, True, False, True, False, False, True)


def rule(scale="linear", steps="[0.1]"):
    return rules_of(STUDY.format(scale=scale, steps=steps))["detectionthreshold"]


def track(who, answers, number=1, **columns):
    rows = {"participant_id": who, "session": "", "run": "01", "track": number, "task": "t"}
    return pd.DataFrame([{**rows, "correct": correct, **columns} for correct in answers])


def test_reversals_are_averaged_by_track_then_by_participant_and_short_tracks_are_counted():
    main = pd.concat(
        [
            track("a", ANSWERS),  # last two turns: 0.2 and 0.4
            track("a", ANSWERS[:-2], number=2),  # 0.2 and 0.3
            track("b", ANSWERS[:3]),  # one turn
            track("c", ANSWERS[:4]),  # 0.2 and 0.3
            track("d", ANSWERS),
        ]
    )
    found = reversals(main, rule(), 2, 0.95)
    (only,) = found.conditions
    assert found.proportion == 0.5
    assert (only.condition, only.tracks, only.left_out) == ("", 5, 1)
    own = {each.participant: each.mean_level for each in only.people}
    assert own == pytest.approx({"a": 0.275, "b": float("nan"), "c": 0.25, "d": 0.3}, nan_ok=True)
    assert only.mean_level.value == pytest.approx(0.275)


def test_means_are_geometric_on_a_logarithmic_scale_and_separate_by_condition():
    easy, hard = ({FACTOR + "speed": level} for level in ("fast", "slow"))
    main = pd.concat(
        [
            track("a", ANSWERS, **easy),  # turns at 0.1, 0.2, 0.1, 0.4 with steps of a factor of 2
            track("b", ANSWERS, **hard),
            track("a", ANSWERS[:4], **hard),
            track("c", ANSWERS, **hard),
        ]
    )
    fast, slow = reversals(main, rule("log10", "[0.30102999566]"), 2, 0.95).conditions
    assert (fast.condition, slow.condition) == ("fast", "slow")
    assert fast.people[0].mean_level == pytest.approx(0.2)
    assert [each.mean_level for each in slow.people] == pytest.approx([0.02**0.5, 0.2, 0.2])
    assert isinstance(fast.mean_level, NotComputed)  # one participant has no interval
    assert slow.mean_level.value == pytest.approx((0.02**0.5 * 0.2 * 0.2) ** (1 / 3))


@pytest.mark.parametrize("tracks, last", [(None, 2), ("rule", None)])
def test_without_a_rule_or_a_request_the_reason_is_stated(tracks, last):
    found = reversals(track("a", ANSWERS), tracks and rule(), last, 0.95)
    assert isinstance(found, NotComputed)
