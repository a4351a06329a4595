"""Flags and exclusions: raised by their rule, counted, and never on their own."""

from dataclasses import fields
from typing import get_args

import pytest

from analysis.pipeline import analyse
from analysis.preprocessing import data_quality
from analysis.preprocessing.log_transform import ZERO_RULES
from analysis.reading.load import load
from analysis.statistics.run_all import Inference
from experiments.study.analysis_choices import Flag, Test, Thresholds, ZeroRule
from faults import UserError


def flags_of(dataset, label="02", **kwargs):
    data = load(dataset(**kwargs))
    measured = data_quality.measures(data, Thresholds())
    row = data_quality.flags(measured, Thresholds()).loc[f"sub-{label}"]
    return {name for name in row.index if row[name]}


def test_the_study_file_knows_exactly_the_flags_tests_and_zero_rules_there_are():
    assert set(get_args(Flag)) == set(data_quality.DECISIONS) == set(data_quality.MEANINGS)
    assert {*get_args(Test), "normalisation"} == {field.name for field in fields(Inference)}
    assert set(get_args(ZeroRule)) == set(ZERO_RULES)


def test_ordinary_participants_carry_no_flag(dataset):
    assert flags_of(dataset) == set()


def changed(dataset, **changes):
    rows = dataset.default_estimates(2, repetitions=4)
    for row, values in zip(rows, zip(*changes.values(), strict=True), strict=False):
        row |= dict(zip(changes, values, strict=True))
    return {"02": rows}


@pytest.mark.parametrize(
    "changes,expected",
    [
        ({"estimate": [5, 60] * 8}, {"constant", "non_monotone"}),
        ({"estimate": [0, 20, 50, 80] * 2 + [0, 21, 52, 83] * 2}, set()),
        ({"estimate": [0, 0, 50, 80] * 2 + [0, 1, 52, 83] * 2}, {"zeros"}),
        ({"estimate": [10, 20, 50, 80] * 2 + [80, 50, 20, 10] * 2}, {"unreliable"}),
        ({"response_time": [0.1, 0.15, 2, 2] * 4}, {"fast"}),
        ({"flag": ["represented;fault"] * 8}, {"faults"}),
        ({"estimate": ["n/a"] * 4, "flag": ["timed_out"] * 4}, {"timed_out"}),
        ({"estimate": [10, 20, 50, 80] * 3 + [10, 20, 50, 8000]}, {"outlying"}),
    ],
)
def test_each_flag_is_raised_by_what_it_names(dataset, changes, expected):
    found = flags_of(dataset, rows=changed(dataset, **changes))
    assert expected <= found
    if not expected:
        assert not found & {"zeros", "constant", "non_monotone"}


def test_drift_is_seen_as_a_factor(dataset):
    base = [10, 20, 50, 80] * 4
    grown = [value * 1.1**place for place, value in enumerate(base)]
    data = load(dataset(rows=changed(dataset, estimate=grown)))
    measured = data_quality.measures(data, Thresholds())
    assert measured.loc["sub-02", "drift"] == pytest.approx(1.1**15, rel=0.25)
    assert data_quality.flags(measured, Thresholds()).loc["sub-02", "drift"]


def test_yes_on_catch_steps_is_a_false_alarm(dataset):
    row = dataset.difference_row
    calm = [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "no")]
    eager = [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "yes")]
    people = {f"{n:02d}": calm for n in range(1, 7)} | {"02": eager}
    assert "false_alarms" in flags_of(dataset, differences=people)


BAD = {"estimate": [80, 50, 20, 10] * 4}


def test_a_flag_alone_excludes_nobody_and_results_are_shown_both_ways(dataset, page):
    analysis = analyse(dataset(rows=changed(dataset, **BAD)))
    assert analysis.excluded == {}
    assert [row.n for row in analysis.robustness] == [6, 5]
    assert "without the flagged" in page(analysis)
    assert "nobody was excluded" in page(analysis)


def test_the_study_s_rule_excludes_before_anything_is_described(dataset, page):
    folder = dataset(
        rows=changed(dataset, **BAD), choices='exclusions = ["non_monotone", "constant"]'
    )
    analysis = analyse(folder)
    assert analysis.excluded == {"sub-02": ("non_monotone",)}
    assert set(analysis.table3["n"]) == {5}
    assert "sub-02 (non_monotone)" in page(analysis)
    assert len(analysis.flags) == 6


def test_thresholds_come_from_the_study(dataset):
    folder = dataset(
        rows=changed(dataset, **BAD),
        choices='exclusions = ["non_monotone"]\nthresholds = { falling_steps = 4 }',
    )
    assert analyse(folder).excluded == {}


def test_exclusions_that_leave_nobody_are_refused(dataset):
    folder = dataset(choices='exclusions = ["constant"]\nthresholds = { distinct_numbers = 99 }')
    with pytest.raises(UserError, match="leave no participant"):
        analyse(folder)
