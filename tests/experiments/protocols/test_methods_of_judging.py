"""Same–different, limits, identification, sorting and categories: plans and simulated answers."""

from collections import Counter
from dataclasses import replace

import pytest

from slipscale.experiments.participants.simulated_people.bare_run import bare_run
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.steps.replies import Reply, Voided
from slipscale.experiments.steps.steps import Ask, EndTrial, Explore, Present
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError

STUDY = """
name = "methods"
title = "Methods of judging"
amplitudes_um_pp = [0.0, 0.8, 1.6, 2.4]
[[tasks]]
protocol = "same_different"
repetitions = 4
practice = 0
[[tasks]]
protocol = "limits"
lowest_um_pp = 0.2
highest_um_pp = 1.4
step_um_pp = 0.2
series = 3
[[tasks]]
protocol = "identification"
repetitions = 4
practice = 1
[[tasks]]
protocol = "sorting"
groups = 2
[[tasks]]
protocol = "category_scale"
labels = ["not at all", "a little", "clearly", "very much"]
practice = 0
"""


@pytest.fixture(scope="module")
def run(plan):
    return plan(STUDY, seed=4)


@pytest.fixture(scope="module")
def trials(run):
    """Each task's answered main trials: factors, levels presented, answer."""
    found, shown = {}, {}
    for step, answer, _ in bare_run(run):
        if isinstance(step, Present) and step.trial:
            shown.setdefault((step.trial.task, step.trial.number), []).append(step.surface.level)
        if isinstance(step, Ask) and step.trial and step.trial.phase == "main":
            levels = shown[step.trial.task, step.trial.number]
            row = (step.trial.factors, levels, answer.value)
            found.setdefault(step.trial.task, []).append(row)
    return found


def test_same_pairs_are_as_frequent_as_different_ones_and_people_tell_them_apart(trials, run):
    rows = trials["samedifferent"]
    kinds = Counter(tuple(sorted(levels)) for _, levels, _ in rows)
    assert {pair: n for pair, n in kinds.items() if len({*pair}) == 2} == dict.fromkeys(
        ((a, b) for a in (0.0, 0.8, 1.6, 2.4) for b in (0.8, 1.6, 2.4) if a < b), 4
    )
    assert {pair: n for pair, n in kinds.items() if len({*pair}) == 1} == {
        (level, level): 6 for level in (0.0, 0.8, 1.6, 2.4)
    }
    yes = {same: [value for _, (a, b), value in rows if (a == b) is same] for same in (True, False)}
    assert sum(yes[False]) / 24 > sum(yes[True]) / 24 + 0.5
    context = run.context("samedifferent")
    protocol = load_protocol("same_different")
    assert protocol.trials(run.study.tasks[0], context) == len(rows)


def test_series_end_where_the_answer_changes_and_begin_at_different_levels(trials):
    series, begins = {}, set()
    for factors, levels, value in trials["limits"]:
        series.setdefault(factors["series"], []).append((factors["direction"], levels, value))
    assert [each[0][0] for each in series.values()].count("ascending") == 3
    for rows in series.values():
        direction, (standard, first), _ = rows[0]
        begins.add((direction, first))
        assert standard == 0.0
        assert [value for *_, value in rows] == [
            *[direction == "descending"] * (len(rows) - 1),
            direction == "ascending",
        ]
    assert len(begins) > 3


def steps_until(steps, kind, answer):
    """Go on to the next step of a kind, answering all questions alike."""
    step = steps.send(answer)
    while not isinstance(step, kind):
        step = steps.send(Reply(value=False) if isinstance(step, Ask) else None)
    return step


def test_a_voided_trial_of_a_series_is_done_again_with_those_after_it(run):
    context = replace(run.context("limits"), texts=run.texts())
    steps = load_protocol("limits").steps(run.study.tasks[1], context)
    ends = [steps_until(steps, EndTrial, None)]
    ends.append(steps_until(steps, EndTrial, Voided()))
    series = [end.trial.factors["series"] for end in ends]
    if series[1] != series[0]:  # the first was descending, and over
        ends = [ends[1], steps_until(steps, EndTrial, Voided())]
    again = steps_until(steps, EndTrial, Voided(trials=(ends[0].trial.number,))).trial
    assert again.repeats == ends[0].trial.number
    assert again.factors == ends[0].trial.factors


def test_numbers_are_learned_first_and_then_named(trials, run):
    learned = [
        step.text
        for step, _, _ in bare_run(run)
        if isinstance(step, Explore) and step.trial is None and "This is surface" in step.text
    ]
    assert len(learned) == 8
    assert learned[1] == "This is surface 2. Stroke it and remember its number."
    rows = trials["identification"]
    right = sum(f"{levels[0]:g}" == value for _, levels, value in rows)
    assert (len(rows), right > 10) == (16, True)


def test_surfaces_that_feel_alike_share_a_group_and_stronger_ones_a_higher_category(trials):
    groups = {levels[0]: value for _, levels, value in trials["sorting"]}  # the last counts
    assert groups[0.0] != groups[2.4]
    assert len(trials["sorting"]) == 8
    means = {}
    for factors, levels, value in trials["categoryscale"]:
        assert factors["categories"] == 4
        means.setdefault(levels[0], []).append(int(value))
    assert sum(means[2.4]) > sum(means[0.0])


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("[0.0, 0.8, 1.6, 2.4]", "[0.8]", "same_different needs 2 surfaces, but the study has 1"),
        ("[0.0, 0.8, 1.6, 2.4]", "[0.8, 1.0]", "sorting needs 3 surfaces, but the study has 2"),
        ("step_um_pp = 0.2", "step_um_pp = 0.6", "has 3 levels; expected at least start_steps"),
        ('"a little", "clearly", "very much"', "", "labels of item 5 .*at least 2"),
        (
            "[0.0, 0.8, 1.6, 2.4]",
            str([round(0.2 * n, 1) for n in range(10)]),
            "identification: amplitudes_um_pp has 10, expected 2 to 9",
        ),
    ],
)
def test_what_a_method_cannot_use_is_refused(old, new, said):
    with pytest.raises(UserError, match=said):
        parse_study(STUDY.replace(old, new), "methods.toml")
