"""Flags and exclusions: raised by their rule, counted, and never on their own."""

from typing import get_args

import numpy as np
import pandas as pd
import pytest

from benchmarks.flags import share_flagged
from slipscale.analysis.load import load
from slipscale.analysis.pipeline import analyse
from slipscale.analysis.preprocessing import data_quality
from slipscale.analysis.preprocessing.log_transform import ZERO_RULES
from slipscale.analysis.tasks.table import STATISTICS
from slipscale.experiments.dataset.hand_exclusions import decide
from slipscale.experiments.study.analysis_choices import (
    AnalysisChoices,
    QualityFlag,
    Test,
    Thresholds,
    ZeroRule,
)
from slipscale.faults import UserError

pytestmark = pytest.mark.usefixtures("without_models")


def flags_of(dataset, label="02", **kwargs):
    data = load(dataset(**kwargs))
    measured = data_quality.measures(data, Thresholds())
    row = data_quality.flags(measured, Thresholds()).loc[f"sub-{label}"]
    return {name for name in row.index if row[name]}


def test_the_study_file_knows_exactly_the_flags_tests_and_zero_rules_there_are():
    assert set(get_args(QualityFlag)) == set(data_quality.DECISIONS) == set(data_quality.MEANINGS)
    assert set(data_quality.LIMITS) == set(data_quality.MEANINGS)
    limits = [name for names in data_quality.LIMITS.values() for name in names]
    assert sorted(limits) == sorted(Thresholds.model_fields)
    assert set(get_args(Test)) == {each.key for each in STATISTICS if each.test}
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
        ({"estimate": [5, 60] * 8}, {"constant"}),
        ({"estimate": [80, 50, 30, 20] * 4}, {"non_monotone"}),
        ({"estimate": [0, 20, 50, 80] * 2 + [0, 21, 52, 83] * 2}, set()),
        ({"estimate": [0, 0, 50, 80] * 3 + [0, 0, 52, 83]}, {"zeros"}),
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


#: Flag: its threshold by default, a little less and a little more, and which of the three flag.
BORDERS = {
    "non_monotone": ((0, 1, 2), (False, True, True)),
    "constant": ((1, 2, 3), (True, True, False)),
    "zeros": ((0.249, 0.25, 0.251), (False, False, True)),
    "timed_out": ((0.099, 0.1, 0.101), (False, False, True)),
    "fast": ((0.049, 0.05, 0.051), (False, False, True)),
    "outlying": ((0, 1, 2), (False, True, True)),
    "unreliable": ((0.499, 0.5, 0.501), (True, False, False)),
    "drift": ((1.999, 2.0, 2.001), (False, False, True)),
    "false_alarms": ((0.499, 0.5, 0.501), (False, False, True)),
    "faults": ((0.249, 0.25, 0.251), (False, False, True)),
}


def test_there_is_a_border_for_every_flag():
    assert set(BORDERS) == set(get_args(QualityFlag))


@pytest.mark.parametrize("name", BORDERS)
def test_a_flag_begins_exactly_at_its_threshold_and_never_without_a_measure(name):
    values, expected = BORDERS[name]
    measured = pd.DataFrame({flag: [np.nan] * 4 for flag in BORDERS})
    measured[name] = [*values, np.nan]
    flagged = data_quality.flags(measured, Thresholds())
    assert tuple(flagged[name]) == (*expected, False)
    assert not flagged.drop(columns=name).any(axis=None)


def test_an_answer_at_the_limit_of_time_is_not_too_fast(dataset):
    rows = dataset.default_estimates(2)
    for row, seconds in zip(rows, (0.2, 0.199), strict=False):
        row |= {"response_time": seconds}
    measured = data_quality.measures(load(dataset(rows={"02": rows})), Thresholds())
    assert measured.loc["sub-02", "fast"] == 1 / len(rows)


def drifting(table_by_hand, trials, rate=1.1, people=2):
    """Participants in turn grow and shrink by a rate a trial, in the same order of surfaces."""
    lines = [
        f"p{who},{amplitude},{20 * amplitude * rate ** (place * (-1) ** who)!r}\n"
        for who in range(people)
        for place, amplitude in enumerate(([1, 2] * trials)[:trials])
    ]
    return load(table_by_hand("participant_id,amplitude_um_pp,estimate\n" + "".join(lines)))


@pytest.mark.parametrize("trials", [8, 16])
def test_drift_is_the_factor_from_the_first_trial_to_the_last(table_by_hand, trials):
    data = drifting(table_by_hand, trials)
    found = data_quality.measures(data, Thresholds())["drift"]
    assert list(found) == pytest.approx([1.1 ** (trials - 1)] * 2)


def test_seven_trials_show_no_drift(table_by_hand):
    found = data_quality.measures(drifting(table_by_hand, 7), Thresholds())
    assert found["drift"].isna().all()


@pytest.mark.parametrize("people, known", [(2, False), (3, True)])
def test_nobody_is_outlying_among_two(table_by_hand, people, known):
    found = data_quality.measures(drifting(table_by_hand, 8, people=people), Thresholds())
    assert found["outlying"].notna().all() == known


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
    once = [row(1, 2.3, 1.2, "yes"), row(2, 1.2, 1.2, "yes")]
    twice = [*once, row(3, 1.2, 1.2, "yes")]
    for eager, flagged in ((once, False), (twice, True)):
        people = {f"{n:02d}": calm for n in range(1, 7)} | {"02": eager}
        assert ("false_alarms" in flags_of(dataset, differences=people)) is flagged


BAD = {"estimate": [80, 50, 20, 10] * 4}
CONSTANT = {"estimate": [5, 60, 60, 60] * 4}


def test_a_flag_of_the_outcome_is_refused_as_an_exclusion():
    with pytest.raises(ValueError, match="pure noise significant; remove it"):
        AnalysisChoices(exclusions=("constant", "non_monotone"))


def test_honest_participants_are_flagged_in_one_of_twenty_cases_at_most():
    """With 1,000 people per design: docs/validation/measured/statistics.md."""
    found = share_flagged("4 × 3", 96, 1)
    # A rate of 5 % shows at most 9 of 96 (binomial, 95 %).
    assert (found <= 9 / 96).all(), found.to_dict()
    assert found["non_monotone"] == 0


@pytest.mark.parametrize("levels", [4, 7])
def test_whoever_feels_no_difference_is_rarely_called_non_monotone(levels):
    orders = np.random.default_rng(levels).random((4000, levels))
    falls = (np.diff(orders, axis=1) < 0).sum(axis=1)
    share = (falls >= data_quality.rarely_falling(levels)).mean()
    assert 0 < share < 0.05 + 0.007
    # More than half of the steps fall for many more.
    assert (2 * falls > levels - 1).mean() > 0.2


def test_a_zero_at_no_amplitude_is_an_answer_and_two_numbers_for_two_amplitudes_are_not_constant(
    table_by_hand,
):
    rows = "".join(f"{who},{a},{9 * a}\n" for who in "abc" for a in (0, 1) for _ in range(4))
    data = load(table_by_hand("participant_id,amplitude_um_pp,estimate\n" + rows))
    found = data_quality.measures(data, Thresholds())
    assert (found["zeros"] == 0).all()
    assert not data_quality.flags(found, Thresholds()).any(axis=None)


def test_a_drift_within_chance_is_no_drift(table_by_hand):
    rng = np.random.default_rng(5)
    rows = "".join(
        f"p{who},{a},{20 * a * np.exp(rng.normal(0, 0.4)):.6g}\n"
        for who in range(40)
        for a in (1, 2) * 5
    )
    data = load(table_by_hand("participant_id,amplitude_um_pp,estimate\n" + rows))
    measured = data_quality.measures(data, Thresholds())
    # 1.5 standard errors of the factor's logarithm are above 2; a test at .05 errs in 2 of 40.
    assert data_quality.flags(measured, Thresholds())["drift"].mean() <= 5 / 40


def test_a_flag_alone_excludes_nobody_and_results_are_shown_both_ways(dataset, page):
    analysis = analyse(dataset(rows=changed(dataset, **BAD)))
    assert analysis.excluded == {}
    assert [row.n for row in analysis.robustness] == [6, 5]
    assert "without flagged participants" in page(analysis)
    assert "and 0 excluded" in page(analysis)


def test_the_study_s_rule_excludes_before_anything_is_described(dataset, page):
    folder = dataset(
        rows=changed(dataset, **CONSTANT), choices='exclusions = ["zeros", "constant"]'
    )
    analysis = analyse(folder)
    assert analysis.excluded == {"sub-02": ("constant",)}
    assert set(analysis.table3["n"]) == {5}
    assert "sub-02 (constant)" in page(analysis)
    assert len(analysis.flags) == 6


def test_who_is_excluded_by_hand_is_left_out_and_the_report_prints_the_reason(dataset, page):
    folder = dataset()
    for label, seen in (("03", False), ("05", True)):
        (folder / f"sourcedata/sub-{label}").mkdir(parents=True, exist_ok=True)
        decide(folder, label, excluded=True, reason="wore a glove", results_seen=seen)
    analysis = analyse(folder)
    assert analysis.excluded == {
        "sub-03": ("by hand: wore a glove",),
        "sub-05": ("by hand, after results were shown: wore a glove",),
    }
    assert set(analysis.table3["n"]) == {4}
    told = "Excluded before the analysis: sub-03 (by hand"
    assert told in page(analysis)
    decide(folder, "03", excluded=False, reason="it was 04", results_seen=True)
    assert list(analyse(folder).excluded) == ["sub-05"]


def test_thresholds_come_from_the_study(dataset):
    folder = dataset(
        rows=changed(dataset, **BAD),
        choices="thresholds = { falling_steps = 4 }",
    )
    assert not analyse(folder).flags["non_monotone"].any()


def test_exclusions_that_leave_nobody_are_refused(dataset):
    folder = dataset(choices='exclusions = ["fast"]\nthresholds = { fast_s = 999 }')
    with pytest.raises(UserError, match="leave no participant"):
        analyse(folder)
