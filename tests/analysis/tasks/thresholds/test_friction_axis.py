"""Thresholds in measured friction: recovered, and not made larger by errors of measurement."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.thresholds.friction_axis import friction_threshold
from slipscale.analysis.tasks.thresholds.reading import COLUMNS, _friction
from slipscale.experiments.study.analysis_choices import AnalysisChoices

LEVELS, STANDARD = np.linspace(0.4, 2.0, 5), 1.2
JND, NORMAL_QUARTILE = 0.04, 0.6744897501960817


def comparisons(people=6, each=30, error=0.0, per_um=-0.1):
    """Return answers that depend on the true friction, which the finger changes by its own."""
    rng = np.random.default_rng(5)
    rows = []
    for who in range(people):
        skin = rng.normal(0.8, 0.1)
        for level in np.repeat(LEVELS, each):
            change = -per_um * skin / 0.8 * (level - STANDARD)
            target, other = rng.normal([skin - change, skin], error)
            more = change + rng.normal(0, JND / NORMAL_QUARTILE) > 0
            rows.append(
                {
                    "participant_id": f"sub-{who}", "task": "t", "method": "comparison",
                    "catch": False, "session": "", "standard_level": STANDARD,
                    "track_level": level, "correct": more,
                    "target_friction": target, "other_friction": other,
                }
            )  # fmt: skip
    return pd.DataFrame(rows).reindex(columns=list(COLUMNS))


def fitted(rows, by="level_means"):
    choices = AnalysisChoices(threshold_friction=by)
    return friction_threshold(rows, choices, method="comparison", curve="log_normal")


def test_differences_are_recovered_and_errors_of_single_trials_enlarge_them():
    rows = comparisons(people=4, each=20, error=0.05)
    rows.loc[:9, "target_friction"] = np.nan
    found = fitted(rows)
    assert (found.n, found.answers, found.left_out) == (4, 390, 10)
    assert found.lower
    assert found.change.value == pytest.approx(0, abs=0.01)
    low, high = found.just_noticeable.interval
    assert low < JND < high < 3 * JND
    assert found.scatter == pytest.approx(0.05 * 2**0.5, rel=0.1)
    assert found.standard == pytest.approx(0.8, abs=0.1)
    assert found.weber_fraction.value == found.just_noticeable.value / found.standard
    assert fitted(rows, "trials").just_noticeable.value > 1.3 * found.just_noticeable.value


def test_friction_that_rises_with_the_level_has_the_other_sign():
    assert not fitted(comparisons(people=3, each=6, per_um=0.1)).lower


def test_one_trial_gives_a_reason_without_a_warning():
    assert isinstance(fitted(comparisons(people=1, each=1).head(1)), NotComputed)


@pytest.mark.parametrize("by, column", [(None, "trial"), ("trials", "other_friction")])
def test_without_a_request_or_a_measurement_the_reason_is_stated(by, column):
    rows = comparisons(people=3, each=2).assign(**{column: np.nan})
    assert isinstance(fitted(rows, by), NotComputed)


def test_the_targets_friction_is_that_of_its_interval():
    frame = pd.DataFrame(
        {
            "interval1_friction_coefficient": ["0.5", "0.8", "0.7"],
            "interval2_friction_coefficient": ["0.8", "0.6", "n/a"],
            "interval3_friction_coefficient": ["0.6", "n/a", "0.9"],
            "target_interval": ["1", "2", "2"],
        }
    ).assign(file=0, line=[2, 3, 4])
    found = _friction(frame.replace("n/a", np.nan), [], Problems())
    assert found["target_friction"].tolist() == pytest.approx([0.5, 0.6, np.nan], nan_ok=True)
    assert found["other_friction"].tolist() == pytest.approx([0.7, 0.8, 0.8])
