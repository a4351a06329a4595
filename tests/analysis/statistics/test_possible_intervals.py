"""No interval extends beyond what is possible, and constant answers have none."""

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.preprocessing.normalisation import RULES, cell_means, normalise
from slipscale.analysis.statistics.descriptives import describe
from slipscale.analysis.statistics.mean_over_participants import mean_over_participants
from slipscale.analysis.tasks.identification.statistics import TaskIdentification, _task
from slipscale.analysis.tasks.pointing.statistics import _condition
from slipscale.analysis.tasks.ratings.statistics import ratings

T_2 = 4.302653  # quantile of t(2) for 95 %


def rated(values, categories):
    rows = [
        {
            "participant_id": f"{who}",
            "task": "t",
            "surface": surface,
            "level": float(surface),
            "rating": float(value),
            "categories": categories,
            "resolution": 1.0,
            "cursor_start": np.nan,
            "catch": False,
        }
        for surface, own in values.items()
        for who, value in enumerate(own)
    ]
    ((found,),) = (ratings(pd.DataFrame(rows)),)
    return found


@pytest.mark.parametrize("categories, top", [(5.0, 5), (np.nan, 100)])
def test_intervals_of_ratings_end_at_the_ends_of_the_scale(categories, top):
    bottom = 1 if top == 5 else 0
    inside = bottom + (top - bottom) * np.array([0.0, 0.0, 0.5])
    found = rated({"1": inside, "2": top + bottom - inside, "3": [top] * 3}, categories)
    low, high, constant = found.surfaces
    half = T_2 * inside.std(ddof=1) / 3**0.5
    assert low.interval.low == bottom
    assert low.interval.high == pytest.approx(inside.mean() + half, rel=1e-5)
    assert high.interval.high == top
    assert high.interval.low == pytest.approx(top + bottom - inside.mean() - half, rel=1e-5)
    assert "same value" in constant.interval.reason
    for pair in found.pairs:
        if pair.difference:
            assert -(top - bottom) <= pair.difference.interval.low
            assert pair.difference.interval.high <= top - bottom


@pytest.mark.parametrize("rule", ["participant_maximum", "participant_largest_trial"])
def test_means_of_a_participants_maximum_do_not_exceed_it_and_constant_ones_have_no_interval(rule):
    rng = np.random.default_rng(2)
    trials = pd.DataFrame(
        [
            (f"{who}", level, 10 * level * np.exp(rng.normal(0, 0.6)))
            for who in range(3)
            for level in (0.5, 1.2, 2.3)
            for _ in range(2)
        ],
        columns=["participant_id", "level", "estimate"],
    )
    trials = trials.assign(normalised=normalise(trials, rule))
    cells = cell_means(trials, "normalised")
    found = describe(cells, np.log(cells), most=RULES[rule].most)
    ends = found[["mean_high", "geometric_high", "within_high"]].to_numpy()
    assert np.nanmax(ends) <= 100
    assert found["mean_low"].min() >= 0
    # Three times 100, up to rounding: [100.00, 100.00] would be an interval without width.
    constant = pd.DataFrame({2.3: [100.0, 100.0 - 1.5e-14, 100.0 + 1.5e-14]})
    (row,) = describe(constant, np.log(constant)).to_dict("records")
    assert np.isnan([row["mean_low"], row["mean_high"], row["geometric_high"]]).all()


def test_proportions_stay_between_none_and_all():
    found = mean_over_participants(np.array([0.9, 1.0, 1.0]), 0.95, (0.0, 1.0))
    assert found.interval.high == 1
    assert found.interval.low == pytest.approx(0.966667 - T_2 * 0.0577350 / 3**0.5, abs=1e-5)
    rows = [
        {"participant_id": f"{who}", "presented": a, "named": b}
        for who, wrong in enumerate((0, 0, 3))
        for a in "xy"
        for b in [a] * (10 - wrong) + ["y"] * wrong
    ]
    task: TaskIdentification = _task("t", pd.DataFrame(rows), 0.95)
    assert task.share_right.interval.high == 1
    movements = pd.DataFrame(
        [
            (
                f"{who}",
                40.0,
                width,
                40 + offset,
                0.5 + 0.1 * offset,
                float(not missed or offset > 0),
            )
            for who, missed in enumerate((0, 0, 1))
            for width in (5.0, 10.0)
            for offset in (-1.0, 0.5, 1.0, 2.0)
        ],
        columns=["participant_id", "distance_mm", "width_mm", "moved_mm", "movement_time", "hit"],
    )
    assert _condition("without", movements, 0.95).error_share.interval.low == 0
