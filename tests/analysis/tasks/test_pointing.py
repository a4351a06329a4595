"""Pointing: throughput and regression of movements with known numbers."""

import math

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.pipeline import analyse
from slipscale.analysis.reading.delimited import Problems
from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.pointing.statistics import POINTING, TRIALS, _along, of_task
from slipscale.experiments.protocols.pointing import WITH_FEEDBACK
from slipscale.experiments.running.pilot import pilot_plans, run_pilot
from slipscale.experiments.steps.questions.pointing import SLOPE_S_PER_BIT
from slipscale.experiments.study.file import study_text


def movements(who, feedback="none", a=0.1, b=0.2):
    """Return movements whose selections deviate by 1 and -1 mm, and times on a line."""
    return pd.DataFrame(
        [
            {
                "participant_id": who,
                "feedback": feedback,
                "distance_mm": distance,
                "width_mm": width,
                "movement_time": a + b * math.log2(distance / width + 1),
                "moved_mm": distance + away,
                "hit": 1.0,
            }
            for distance, width in ((30.0, 10.0), (70.0, 10.0))
            for away in (-1.0, 1.0, -1.0, 1.0)
        ]
    )


def test_throughput_and_the_line_of_one_participant_are_those_by_hand():
    (found,) = of_task("pointing", movements("a"), 0.95).conditions
    (person,) = found.people
    width = math.sqrt(2 * math.pi * math.e) * math.sqrt(4 / 3)
    by_hand = np.mean(
        [math.log2(30 / width + 1) / (0.1 + 0.2 * 2), math.log2(70 / width + 1) / (0.1 + 0.2 * 3)]
    )
    assert person.throughput_bit_s == pytest.approx(by_hand)
    assert (person.intercept_s, person.slope_s_per_bit) == pytest.approx((0.1, 0.2))
    assert isinstance(found.throughput_bit_s, NotComputed)


def test_feedback_is_compared_within_participants_and_small_cells_are_counted():
    rows = pd.concat(
        [movements(who, f, a) for n, who in enumerate("abc") for f, a in
         (("none", 0.1 + n / 100), ("target", 0.1 - n / 100))]
        + [movements("d").iloc[:5]]
    )  # fmt: skip
    found = of_task("pointing", rows, 0.95)
    assert [each.feedback for each in found.conditions] == ["none", "target"]
    assert found.conditions[0].left_out == 1
    assert found.time_gain_s.mean == pytest.approx(-0.02)
    assert found.time_gain_s.df == 2


def test_a_selection_is_projected_on_the_movement():
    frame = pd.DataFrame(
        [
            [0.0, 0.0, 30.0, 40.0, 33.0, 44.0, "target", ""],
            ["x", 0, 1, 0, 1, 1, "outside", "target"],
        ],
        columns=[
            *("start_x_mm", "start_y_mm", "target_x_mm", "target_y_mm"),
            *("selection_x_mm", "selection_y_mm", "selection", "feedback"),
        ],
    )
    read = _along(frame, Problems())
    assert read["moved_mm"].tolist() == pytest.approx([55.0, math.nan], nan_ok=True)
    assert read["hit"].tolist() == [1.0, 0.0]
    assert read["feedback"].tolist() == ["none", "target"]


def test_a_pilot_recovers_the_slope_and_the_effect_of_feedback(tmp_path):
    text = study_text("pointing2023").replace("[20.0, 40.0, 80.0]", "[20.0, 80.0]")
    short = text.replace("widths_mm = [4.0, 10.0]", "widths_mm = [4.0]")
    (tmp_path / "pointing2023.toml").write_text(short.replace("= 15", "= 6"), "utf-8")
    study = str(tmp_path / "pointing2023.toml")
    plans = pilot_plans(study, participants=3, seed=2, language=None)
    run_pilot(tmp_path / "data", plans, tell=lambda _: None)
    analysis = analyse(tmp_path / "data")
    (found,) = analysis.inference[POINTING]
    assert len(analysis.dataset.of(TRIALS)) == 3 * 24
    none, target = found.conditions
    pace = np.mean([each.movement_time_s for each in target.people]) / np.mean(
        [each.movement_time_s for each in none.people]
    )
    assert pace == pytest.approx(WITH_FEEDBACK, abs=0.05)
    assert none.slope_s_per_bit.mean == pytest.approx(SLOPE_S_PER_BIT, rel=0.5)
    assert found.time_gain_s.mean < 0
