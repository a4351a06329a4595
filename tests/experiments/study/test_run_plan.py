from collections import Counter
from itertools import pairwise

import pytest
from scipy.stats import chisquare

from experiments.protocols.steps import Present
from experiments.running.dry_run import dry_run

STUDY = """
name = "ordered"
title = "Two tasks"
amplitudes_um_pp = [0.0, 0.5, 1.2, 2.3]
task_order = "{order}"
[[tasks]]
protocol = "descending_difference"
[[tasks]]
protocol = "magnitude_estimation"
randomisation = "williams"
practice = 0
repetitions = {repetitions}
"""
LISTED = ("descendingdifference", "magnitudeestimation")


def tasks(plan):
    return tuple(protocol.task for protocol, _ in plan.tasks())


def study(order="counterbalanced", repetitions=1):
    return STUDY.format(order=order, repetitions=repetitions)


def test_in_fixed_order_every_participant_has_the_tasks_as_the_study_lists_them(plan):
    orders = {tasks(plan(study("fixed"), participant=f"{n:02d}")) for n in range(1, 13)}
    assert orders == {LISTED}


@pytest.mark.parametrize("count", [2, 4, 12])
def test_counterbalanced_tasks_come_equally_often_in_either_order(plan, count):
    orders = [tasks(plan(study(), participant=f"{n:02d}")) for n in range(1, count + 1)]
    assert Counter(orders) == {LISTED: count // 2, LISTED[::-1]: count // 2}
    assert orders[0] == LISTED  # the first participant has them as the study lists them


def test_counterbalanced_tasks_are_balanced_over_labels_that_are_no_numbers(plan):
    turned = [tasks(plan(study(), participant=f"P{n}x")) != LISTED for n in range(400)]
    assert chisquare([sum(turned), 400 - sum(turned)]).pvalue > 1e-4


def test_the_place_in_the_counterbalancing_is_the_number_however_it_is_written(plan):
    rows = [plan(participant=label).row for label in ("1", "01", "001", "2", "12", "0")]
    assert rows == [0, 0, 0, 1, 11, 0]
    assert plan(participant="P1").row == plan(participant="P1").row != plan(participant="P2").row


@pytest.mark.parametrize("order", ["fixed", "counterbalanced"])
def test_the_steps_of_a_run_follow_the_order_of_its_tasks(plan, order):
    for participant in ("01", "02"):
        made = plan(study(order), participant=participant)
        seen = [s.trial.task for s in dry_run(made) if isinstance(s, Present) and s.trial]
        assert tuple(dict.fromkeys(seen)) == tasks(made)
        assert len(seen) == made.planned_trials() == 4 + 4


@pytest.mark.parametrize("order", ["fixed", "counterbalanced"])
@pytest.mark.parametrize("repetitions", [1, 2])
def test_surfaces_follow_each_other_equally_often_over_the_participants(plan, order, repetitions):
    follows, places = Counter(), Counter()
    for number in range(1, 13):
        made = plan(study(order, repetitions), participant=f"{number:02d}")
        shown = [
            step.surface.label
            for step in dry_run(made)
            if isinstance(step, Present) and step.trial and step.trial.task == LISTED[1]
        ]
        for block in (shown[at : at + 4] for at in range(0, len(shown), 4)):
            follows.update(pairwise(block))
            places.update(enumerate(block))
    assert len(follows) == 12
    assert len(set(follows.values())) == 1
    assert len(places) == 16
    assert len(set(places.values())) == 1
