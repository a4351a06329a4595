"""Scales from tables of pairs and triads: the known order and distances come back."""

from itertools import combinations, pairwise

import numpy as np
import pandas as pd
import pytest

from slipscale.analysis.statistics.not_computed import NotComputed
from slipscale.analysis.tasks.scales.declaration import ANALYSIS
from slipscale.analysis.tasks.scales.statistics import scales
from slipscale.stimuli.quantity import PLATE_AMPLITUDE

VALUES = {"0.5": -1.0, "1.2": 0.0, "2.3": 0.8, "fine": 0.2}


def pairs(people=8, each=20, seed=5, values=VALUES):
    rng = np.random.default_rng(seed)
    rows = []
    for who in range(people):
        for one in values:
            for other in values:
                for _ in range(each if one < other else 0):
                    first, second = (one, other) if rng.random() < 0.5 else (other, one)
                    p = 1 / (1 + np.exp(values[second] - values[first]))
                    rows.append(
                        (f"sub-{who:02d}", first, second, "", 1.0 if rng.random() < p else 2.0)
                    )
    return table(rows, "pairs")


def triads(people=6, each=30, seed=6, noise=0.15):
    rng = np.random.default_rng(seed)
    scale = {"0.5": 0.0, "1": 0.5, "1.5": 0.8, "2": 1.0}
    names = list(scale)
    rows = []
    for who in range(people):
        for a, b, c in [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]:
            for _ in range(each):
                three = [names[a], names[b], names[c]]
                one, two = (abs(scale[y] - scale[x]) for x, y in pairwise(three))
                larger = 2.0 if two - one + noise * rng.normal() > 0 else 1.0
                rows.append((f"sub-{who:02d}", *three, larger))
    return table(rows, "triads")


def table(rows, task):
    frame = pd.DataFrame(
        rows, columns=["participant_id", "stimulus1", "stimulus2", "stimulus3", "response"]
    ).assign(task=task, catch=False, trial=range(1, len(rows) + 1), session="", run="01")
    return frame.assign(participant_id=pd.Categorical(frame["participant_id"]))


def test_the_distances_of_pairs_are_recovered_within_their_errors():
    (found,) = scales(pairs())
    assert found.surfaces == ("0.5", "1.2", "2.3", "fine")
    truth = np.array([VALUES[name] for name in found.surfaces])
    truth -= truth.mean()
    for value, true, (low, high) in zip(
        found.bradley_terry.values, truth, found.bradley_terry.intervals, strict=True
    ):
        assert abs(value - true) < 3 * (high - low) / 4
    assert np.argsort(found.thurstone.values).tolist() == np.argsort(truth).tolist()
    assert isinstance(found.differences, NotComputed)


def test_choices_are_counted_by_hand():
    rows = [
        ("sub-01", "a", "b", "", 1.0),
        ("sub-01", "b", "a", "", 1.0),
        ("sub-01", "b", "c", "", 2.0),
        ("sub-01", "c", "a", "", 2.0),
    ]
    (found,) = scales(table(rows, "pairs"))
    assert found.surfaces == ("a", "b", "c")
    assert found.chosen == (2, 1, 1)
    assert found.compared == (3, 3, 2)
    assert set(found.consistency) == {"sub-01"}


def test_catch_trials_take_no_part():
    plain = pairs(people=3)
    catches = plain.head(5).assign(catch=True, response=2.0)
    (found,) = scales(pd.concat([plain, catches], ignore_index=True))
    assert (found.answers, found.catch_trials) == (len(plain), 5)


def test_triads_give_the_scale_of_differences():
    (found,) = scales(triads())
    assert isinstance(found.bradley_terry, NotComputed)
    scale = found.differences
    assert list(scale.values) == pytest.approx((0.0, 0.5, 0.8, 1.0), abs=0.08)


def test_triads_of_textures_have_no_scale_and_say_why():
    frame = triads(people=1, each=2).replace({"1.5": "coarse"})
    (found,) = scales(frame)
    assert "coarse" in found.differences.reason


def test_answers_without_errors_have_a_scale_in_their_order():
    frame = pairs(people=3, values={name: 40 * value for name, value in VALUES.items()})
    (found,) = scales(frame)
    assert np.argsort(found.bradley_terry.values).tolist() == [0, 1, 3, 2]
    assert found.chosen[0] == 0


def test_scale_values_that_are_all_equal_are_in_no_order():
    names = ["0.5", "1.2", "2.3"]
    both = [
        (who, one, other, "", response)
        for who in ("sub-01", "sub-02", "sub-03")
        for one, other in combinations(names, 2)
        for response in (1.0, 2.0)
    ]
    (found,) = scales(table(both, "pairs"))
    said = ANALYSIS.task_answer(found, 0.95, PLATE_AMPLITUDE)
    assert said.endswith(
        ": all scale values (Bradley-Terry model, natural log odds of a choice, mean 0) were 0.00 "
        "(0.5 µm, 1.2 µm and 2.3 µm)."
    )


def test_without_trials_it_is_said():
    assert scales(pairs().head(0)) == NotComputed("no trials of paired comparison")
