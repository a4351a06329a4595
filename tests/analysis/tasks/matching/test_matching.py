"""Matching: bias, variability and direction against plain NumPy and SciPy."""

import re

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from slipscale.analysis.reporting.multiplicity import multiplicity
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.statistics.statistic import Inference
from slipscale.analysis.tasks.matching.declaration import ANALYSIS
from slipscale.analysis.tasks.matching.statistics import MATCHING, matching
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

REFERENCES, BIAS = (0.8, 1.6), 0.1


def matches(people=6, each=4, hysteresis=0.06):
    rng = np.random.default_rng(2)
    rows = [
        (
            f"sub-{who:02d}",
            reference,
            direction,
            reference + BIAS + side + own + 0.05 * rng.normal(),
        )
        for who in range(people)
        for own in [0.03 * rng.normal()]
        for reference in REFERENCES
        for direction, side in (("ascending", -hysteresis / 2), ("descending", hysteresis / 2))
        for _ in range(each)
    ]
    frame = pd.DataFrame(
        rows, columns=["participant_id", "reference_level", "direction", "matched_level"]
    ).assign(task="matching", catch=False, felt_again=np.nan)
    return frame.assign(participant_id=pd.Categorical(frame["participant_id"]))


def test_bias_and_direction_are_students_tests_of_one_value_a_participant():
    frame = matches()
    found = matching(frame)
    assert [each.reference_level for each in found] == [0.8, 1.6]
    for each in found:
        rows = frame[frame["reference_level"] == each.reference_level]
        own = rows.groupby("participant_id", observed=True)["matched_level"].mean()
        test = stats.ttest_1samp(own - each.reference_level, 0)
        assert each.bias_level.mean == pytest.approx(own.mean() - each.reference_level)
        assert each.bias_level.p == pytest.approx(test.pvalue)
        up, down = (
            rows[rows["direction"] == name].groupby("participant_id", observed=True)[
                "matched_level"
            ]
            for name in ("ascending", "descending")
        )
        paired = stats.ttest_rel(down.mean(), up.mean())
        assert each.direction_level.p == pytest.approx(paired.pvalue)
        assert each.direction_level.mean == pytest.approx(
            each.descending_level - each.ascending_level
        )


def test_variability_is_that_within_a_person_and_direction():
    (found, _) = matching(matches(people=40, each=10, hysteresis=0.5))
    assert found.variability_level == pytest.approx(0.05, rel=0.1)


def test_a_single_match_from_each_side_has_no_variability():
    (found, _) = matching(matches(each=1))
    assert found.variability_level is None


def test_two_participants_have_means_and_no_tests():
    (found, _) = matching(matches(people=2))
    assert isinstance(found.bias_level, NotComputed)
    assert found.mean_level > 0.8


def test_one_direction_only_leaves_the_comparison_out():
    frame = matches()
    (found, _) = matching(frame[frame["direction"] == "ascending"])
    assert found.descending_level is None
    assert isinstance(found.direction_level, NotComputed)


def test_without_trials_it_is_said():
    assert matching(matches().head(0)) == NotComputed("no trials of matching")


def with_catch_trials(frame, *reached):
    """Trials that began at 0.8 µm, and were turned to these."""
    caught = frame.head(len(reached)).assign(
        catch=True, direction="equal", reference_level=0.8, matched_level=reached
    )
    return pd.concat([frame, caught], ignore_index=True)


def test_catch_trials_are_no_matches_and_are_told_by_themselves():
    plain, caught = matching(matches()), matching(with_catch_trials(matches(), 0.7, 1.1))
    assert [each.bias_level for each in caught] == [each.bias_level for each in plain]
    assert [each.matches for each in caught] == [each.matches for each in plain]
    assert [each.catch_trials for each in caught] == [2, 0]
    assert caught[0].catch_error_level == pytest.approx((0.1 + 0.3) / 2)
    assert caught[1].catch_error_level is None


def test_catch_trials_alone_are_no_matches():
    frame = with_catch_trials(matches(), 0.7)
    assert matching(frame[frame["catch"]]) == NotComputed("no trials of matching")


def test_how_often_the_reference_was_felt_again_is_a_mean_over_matches():
    frame = with_catch_trials(matches().assign(felt_again=1.5), 0.8)
    frame.loc[frame["catch"], "felt_again"] = 9.0
    assert [each.felt_again for each in matching(frame)] == [1.5, 1.5]
    assert matching(matches())[0].felt_again is None


def test_the_table_shows_repeated_references_and_catch_trials():
    frame = with_catch_trials(matches().assign(felt_again=1.5), 0.7)
    (table,) = ANALYSIS.task_blocks(matching(frame), {}, 95, PLATE_AMPLITUDE)
    first, second = re.findall(r"<td[^>]*>1.50</td>\s*<td[^>]*>(.*?)</td>\s*<td[^>]*>(.*?)<", table)
    assert (first, second) == (("1", "0.100"), ("0", "–"))


def test_tests_of_bias_and_direction_are_in_the_list_of_all_tests():
    found = multiplicity(Inference().with_result(MATCHING, matching(matches())), "ranks", 0.95)
    # The simulated bias is found for both references, and so is the effect of direction.
    assert [(each.name, each.tests, each.below) for each in found.families] == [
        ("bias of matches, t tests", 2, 2),
        ("direction of adjustment, t tests", 2, 2),
    ]


def test_the_number_of_uncorrected_tests_is_stated():
    found = list(matching(matches()))
    (text,) = ANALYSIS.task_remarks(found, 0.95, PLATE_AMPLITUDE)
    assert "at 2 references, without correction" in text
    assert "about 10 % of studies" in text
    assert ANALYSIS.task_remarks(found[:1], 0.95, PLATE_AMPLITUDE) == []
