"""A run's tasks and orders: how they follow from participant, session and run."""

from collections import Counter
from itertools import pairwise

import pytest
from scipy.stats import chisquare

from slipscale.experiments.running.rehearsal import dry_run
from slipscale.experiments.running.study_commands import orders
from slipscale.experiments.steps.steps import Present
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError

TASK = "magnitudeestimation"
VISITS = '\nsessions = ["pre", "post"]\nruns = 2\n'
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


def with_keys(keys):
    return study_text("biet2007").replace("\nseed = 2007", f"\nseed = 2007\n{keys}")


@pytest.mark.parametrize(
    "label, row", [("01", 0), ("1", 0), ("P01", 0), ("P12", 11), ("s2p007", 6), ("00", 0)]
)
def test_the_row_follows_the_number_that_a_label_ends_with(plan, label, row):
    assert plan(participant=label).row == row


def test_labels_with_a_letter_before_their_number_fill_the_rows_evenly(plan):
    """Once a hash was taken: over P01 to P12 the rows modulo 4 were 3 1 3 2 2 0 2 2 3 1 1 3."""
    rows = [plan(participant=f"P{number:02d}").row % 4 for number in range(1, 13)]
    assert rows == [0, 1, 2, 3] * 3


def test_a_label_without_a_number_has_a_row_of_its_own(plan):
    assert plan(participant="anna").row == plan(participant="anna").row
    assert plan(participant="anna").row != plan(participant="otto").row


def test_every_session_and_run_has_orders_of_its_own(plan):
    """Once a second session repeated the first's."""
    visits = [("", "01"), ("02", "01"), ("", "02"), ("02", "02"), ("03", "01")]
    drawn = [orders(plan(session=session, run=run))[TASK] for session, run in visits]
    assert len(set(drawn)) == len(visits)
    assert drawn[1] == orders(plan(session="02"))[TASK]


def test_catch_steps_come_at_other_places_in_other_sessions(plan):
    drawn = {orders(plan(session=f"{n:02d}"))["descendingdifference"] for n in range(1, 12)}
    assert len(drawn) > 1


@pytest.mark.parametrize(
    "session, run, visit",
    [("pre", "01", 0), ("pre", "02", 1), ("post", "01", 2), ("post", "02", 3)],
)
def test_visits_are_counted_as_the_study_plans_them(plan, session, run, visit):
    assert plan(with_keys(VISITS), session=session, run=run).visit == visit


def test_without_planned_sessions_visits_are_counted_by_their_numbers(plan):
    assert [plan(session=each).visit for each in ("", "01", "02", "s3", "post")] == [0, 0, 1, 2, 0]


def test_a_session_that_the_study_does_not_plan_is_refused(plan):
    with pytest.raises(
        UserError, match="--session 'mid': expected one of the study's sessions: pre, post"
    ):
        plan(with_keys(VISITS), session="mid").context()


@pytest.mark.parametrize("visits, turned", [("advance", True), ("same", False)])
def test_the_order_of_tasks_turns_with_the_visit_if_visits_advance(plan, visits, turned):
    text = with_keys(f'task_order = "counterbalanced"\nvisits = "{visits}"\n')
    first, second = (
        [protocol.task for protocol, _ in plan(text, session=session).tasks()]
        for session in ("01", "02")
    )
    assert (second == first[::-1]) == turned
    assert (second == first) != turned


def test_orders_of_a_later_version_are_refused(plan):
    with pytest.raises(UserError, match=r"orders of version 3, .* generates version 2"):
        plan(order_version=3)
