"""Constant stimuli, paired comparison and matching: what is planned is balanced."""

from collections import Counter
from itertools import combinations

import pytest

from slipscale.experiments.running.begin_or_resume import plate_for
from slipscale.experiments.running.rehearsal import check_supported, dry_run
from slipscale.experiments.steps.steps import Present
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock


def trials(made):
    """Return a run's main trials of each task, in order: (trial, amplitudes of its intervals)."""
    found = {}
    for step in dry_run(made):
        if isinstance(step, Present) and step.trial and step.trial.phase == "main":
            key = (step.trial.task, step.trial.number)
            _, shown = found.setdefault(key, (step.trial, []))
            shown.append(step.surface.level)
    return list(found.values())


def test_each_comparison_comes_equally_often_and_first_as_often_as_second(plan):
    shown = [
        pair for t, pair in trials(plan(study_text("constant_stimuli"))) if not t.factors["catch"]
    ]
    first = Counter(pair[0] for pair in shown if pair[0] != 1.2)
    second = Counter(pair[1] for pair in shown if pair[1] != 1.2)
    assert first == second == dict.fromkeys((1.23, 1.26, 1.32, 1.4, 1.6), 10)
    each = [sorted(pair)[1] for pair in shown]
    for start in range(0, len(each), 5):
        assert sorted(each[start : start + 5]) == [1.23, 1.26, 1.32, 1.4, 1.6]


def test_with_yes_and_no_the_comparison_is_always_second_and_a_catch_is_the_standard(plan):
    text = study_text("constant_stimuli").replace("forced_choice", "yes_no")
    for trial, (first, second) in trials(plan(text)):
        assert first == 1.2
        assert (second == 1.2) == trial.factors["catch"]


def test_every_pair_is_presented_in_both_orders_and_every_triad_in_order(plan):
    made = plan(study_text("paired_comparison"))
    shown = [(t.task, tuple(s)) for t, s in trials(made) if not t.factors["catch"]]
    amplitudes = (1.0, 1.06, 1.12, 1.18, 1.24)
    pairs = [pair for task, pair in shown if task == "pairs"]
    labels = Counter(frozenset(pair) for pair in pairs)
    # The texture's largest amplitude is 1.24 as well: it makes a pair of its own with each surface.
    assert len(pairs) == 2 * len(list(combinations(range(6), 2))) == sum(labels.values())
    for low, high in combinations(amplitudes, 2):
        both = 2 if 1.24 in (low, high) else 1
        assert pairs.count((low, high)) == pairs.count((high, low)) == both
    triads = Counter(triad for task, triad in shown if task == "triads")
    for triad in combinations(amplitudes, 3):
        assert triads[triad] == triads[triad[::-1]] == 1


def test_a_reference_is_matched_from_below_as_often_as_from_above(plan):
    made = plan(study_text("matching"))
    caught = 0
    for reference in (0.8, 1.2, 1.6):
        starts = [pair[1] for _, pair in trials(made) if pair[0] == reference]
        below, above = [s for s in starts if s < reference], [s for s in starts if s > reference]
        assert len(below) == len(above) == 3
        assert all(0.3 <= abs(start - reference) <= 0.6 for start in below + above)
        assert len(set(below + above)) == 6
        caught += starts.count(reference)
    assert caught == 2


@pytest.mark.parametrize(
    "study, change, said",
    [
        ("difference_threshold", ("highest_um_pp = 0.8", "highest_um_pp = 1.4"), "2.6 is beyond"),
        ("difference_threshold", ("standard_um_pp = 1.2", "standard_um_pp = 2.6"), "2.6 is beyond"),
        (
            "difference_threshold",
            ("standard_um_pp = 1.2", 'standard_um_pp = 0.5\ncomparison = "less"'),
            "must be at most the standard",
        ),
        (
            "difference_threshold",
            ("most_trials = 30", "most_trials = 30\nreversals = 40"),
            "this rule could never stop",
        ),
        (
            "difference_threshold",
            ("most_trials = 30", "most_trials = 30\nthreshold_sd_log10 = 0.1"),
            "this method has no threshold_sd_log10",
        ),
        (
            "difference_threshold",
            ("most_trials = 30", "most_trials = 3000"),
            "expected 1000 or less, got 3000",
        ),
        (
            "difference_threshold",
            ("start_um_pp = 0.4", "start_um_pp = 1.0"),
            "the first level is 1, expected 0.02 to 0.8",
        ),
        (
            "detection_threshold",
            ("quest_levels = 40", "quest_levels = 1000"),
            "are 10000000 cells, more than 2000000",
        ),
        (
            "detection_threshold",
            ("most_trials = 60", "most_trials = 60\nthreshold_sd_log10 = 3.0"),
            "expected a smaller value",
        ),
        (
            "detection_threshold",
            ("lowest_um_pp = 0.02", "lowest_um_pp = 1.2"),
            "expected above the lowest",
        ),
        (
            "constant_stimuli",
            ("comparisons_um_pp = [1.23, ", "comparisons_um_pp = [1.26, "),
            "different amplitudes",
        ),
        (
            "constant_stimuli",
            ("comparisons_um_pp = [1.23, 1.26, 1.32, 1.4, 1.6]", "comparisons_um_pp = [1.2]"),
            "other than the standard",
        ),
        (
            "paired_comparison",
            ("[1.0, 1.06, 1.12, 1.18, 1.24]", "[1.0, 1.06]"),
            "compares 3 surfaces, but the study has 2",
        ),
        ("matching", ("[0.8, 1.2, 1.6]", "[0.4]"), "the reference 0.4 µm p-p start at -0.2 to 1"),
        (
            "matching",
            ("furthest_start_um_pp = 0.6", "furthest_start_um_pp = 0.2"),
            "at least nearest_start_um_pp",
        ),
    ],
)
def test_what_cannot_be_is_one_sentence_of_the_study(study, change, said, plan):
    text = study_text(study)
    assert change[0] in text
    with pytest.raises(UserError, match=said):
        plan(text.replace(*change)).study  # noqa: B018 - parsed when it is looked at


@pytest.mark.parametrize(
    "study", ["difference_threshold", "detection_threshold", "constant_stimuli"]
)
def test_levels_finer_than_the_plate_is_held_are_refused_and_say_how_it_is_held(study, plan):
    text = study_text(study)
    made = plan(text)
    check_supported(made, plate_for(made, "mock", VirtualClock()))
    coarse = plan(text.replace("tolerance = 0.01", "").replace("tolerance_um_pp = 0.015", ""))
    with pytest.raises(UserError, match=r"differences down to 0\.0\d µm p-p, but the plate"):
        check_supported(coarse, plate_for(coarse, "mock", VirtualClock()))


def test_a_study_narrows_the_plates_tolerance_and_never_widens_it(plan):
    text = study_text("difference_threshold")
    narrow = plate_for(plan(text), "mock", VirtualClock()).limits
    assert (narrow.tolerance, narrow.deviation_level) == (0.01, 0.015)
    wide = plan(text.replace("= 0.01\n", "= 0.5\n").replace("= 0.015", "= 0.5"))
    limits = plate_for(wide, "mock", VirtualClock()).limits
    assert (limits.tolerance, limits.deviation_level) == (0.05, 0.05)
