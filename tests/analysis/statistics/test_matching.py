"""Matching: bias, variability and direction against plain NumPy and SciPy."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from analysis.statistics.matching import matching
from analysis.statistics.not_computed import NotComputed

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
        rows, columns=["participant_id", "reference_um_pp", "direction", "matched_um_pp"]
    ).assign(task="matching")
    return frame.assign(participant_id=pd.Categorical(frame["participant_id"]))


def test_bias_and_direction_are_students_tests_of_one_value_a_participant():
    frame = matches()
    found = matching(frame)
    assert [each.reference_um_pp for each in found] == [0.8, 1.6]
    for each in found:
        rows = frame[frame["reference_um_pp"] == each.reference_um_pp]
        own = rows.groupby("participant_id", observed=True)["matched_um_pp"].mean()
        test = stats.ttest_1samp(own - each.reference_um_pp, 0)
        assert each.bias_um_pp.mean == pytest.approx(own.mean() - each.reference_um_pp)
        assert each.bias_um_pp.p == pytest.approx(test.pvalue)
        up, down = (
            rows[rows["direction"] == name].groupby("participant_id", observed=True)[
                "matched_um_pp"
            ]
            for name in ("ascending", "descending")
        )
        paired = stats.ttest_rel(down.mean(), up.mean())
        assert each.direction_um_pp.p == pytest.approx(paired.pvalue)
        assert each.direction_um_pp.mean == pytest.approx(
            each.descending_um_pp - each.ascending_um_pp
        )


def test_variability_is_that_within_a_person_and_direction():
    (found, _) = matching(matches(people=40, each=10, hysteresis=0.5))
    assert found.variability_um_pp == pytest.approx(0.05, rel=0.1)


def test_a_single_match_from_each_side_has_no_variability():
    (found, _) = matching(matches(each=1))
    assert found.variability_um_pp is None


def test_two_participants_have_means_and_no_tests():
    (found, _) = matching(matches(people=2))
    assert isinstance(found.bias_um_pp, NotComputed)
    assert found.mean_um_pp > 0.8


def test_one_direction_only_leaves_the_comparison_out():
    frame = matches()
    (found, _) = matching(frame[frame["direction"] == "ascending"])
    assert found.descending_um_pp is None
    assert isinstance(found.direction_um_pp, NotComputed)


def test_without_trials_it_is_said():
    assert matching(matches().head(0)) == NotComputed("no trials of matching")
