"""Pointing: geometry of the targets, what the screen accepts, and what the table contains."""

import itertools
import math
from dataclasses import replace

import pytest

from slipscale.experiments.languages.texts import load_texts
from slipscale.experiments.participants.psychopy_window.screens import screen_for
from slipscale.experiments.protocols.pointing import PROTOCOL, Movement, Pointing, target_surface
from slipscale.experiments.running.contact_sources import ContactSpecs
from slipscale.experiments.running.rehearsal import check_supported, dry_run
from slipscale.experiments.steps.columns import TrialRecord
from slipscale.experiments.steps.questions.pointing import PointingQuestion, Selection
from slipscale.experiments.steps.replies import Reply, Voided
from slipscale.experiments.steps.screens.scene import Box, Disc
from slipscale.experiments.steps.steps import Ask, EndTrial
from slipscale.experiments.study.file import study_text
from slipscale.faults import UserError
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import VirtualClock

POINTING_2023 = study_text("pointing2023")


def asked(made):
    return [step for step in dry_run(made) if isinstance(step, Ask)]


def test_bars_alternate_and_each_movement_starts_at_the_last_target(plan):
    steps = asked(plan(POINTING_2023, study_name="pointing2023"))
    main = [step for step in steps if step.trial.factors["sequence"] == 2]
    assert len(steps) == 5 + 2 * 3 * 2 * 15
    assert len(main) == 15
    distance = main[0].trial.factors["distance_mm"]
    for before, after in itertools.pairwise(main):
        assert after.question.start_mm == before.question.target_mm
        assert abs(after.question.target_mm[0]) == distance / 2
        assert after.question.target_mm[0] == -after.question.start_mm[0]


def test_discs_lie_on_a_ring_and_every_movement_has_the_distance(plan):
    text = POINTING_2023.replace("movements = 15", "movements = 9\ndimensions = 2").replace(
        'feedback = ["none", "target"]', ""
    )
    main = [each.question for each in asked(plan(text)) if each.trial.factors["sequence"] == 3]
    lengths = [math.dist(each.start_mm, each.target_mm) for each in main]
    assert lengths == pytest.approx([lengths[0]] * 9, abs=1e-5)
    assert round(lengths[0]) in {20, 40, 80}
    assert len({each.target_mm for each in main}) == 9


@pytest.mark.parametrize("on, off", [(0.0, 2.3), (2.3, 0.5)])
@pytest.mark.parametrize("target", [-40.0, 40.0])
def test_the_plate_has_its_other_level_on_the_target_only(on, off, target):
    options = Pointing(protocol="pointing", target_level=on, ground_level=off)
    movement = Movement(1, "main", "target", 80.0, 10.0, (-target, 0.0), (target, 0.0))
    surface = target_surface(options, movement)
    edge = 5.0
    for x in (target, target - edge + 0.01, target + edge - 0.01):
        assert surface.level_at(x) == pytest.approx(on)
    for x in (target - edge - 0.01, target + edge + 0.01, 0.0, -target, 3 * target):
        assert surface.level_at(x) == pytest.approx(off)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("movements = 15", "movements = 4\ndimensions = 2", "expected an odd number"),
        ("widths_mm = [4.0, 10.0]", "widths_mm = [25.0]", "overlaps the start, which is 20 mm"),
        ("80.0]", "400.0]", "reach 205 mm from the middle, but the screen has room for 189 mm"),
        ("movements = 15", "dimensions = 2", "expected dimensions = 1"),
        ("target_um_pp = 0.0", "target_um_pp = 2.3", "target_um_pp equals ground_um_pp"),
    ],
)
def test_what_cannot_be_shown_or_felt_is_rejected(plan, old, new, message):
    with pytest.raises(UserError, match=message):
        list(dry_run(plan(POINTING_2023.replace(old, new))))


@pytest.mark.parametrize("of_study, of_command", [("# position = ", None), ("position = ", "none")])
def test_feedback_needs_the_fingers_position(plan, of_study, of_command):
    made = plan(POINTING_2023.replace("position = ", of_study))
    with pytest.raises(UserError, match="position must be measured; name a sensor"):
        check_supported(made, MockPlate(clock=VirtualClock()), ContactSpecs(position=of_command))


@pytest.fixture
def question():
    return PointingQuestion(
        prompt="Go.",
        start_mm=(-30.0, 0.0),
        target_mm=(30.0, 0.0),
        width_mm=6.0,
        bars=True,
        screen_height_mm=300.0,
    )


def shown(question, **more):
    return screen_for(Ask(name="selection", question=question, **more), load_texts("en"))


def test_the_time_runs_from_the_start_to_the_next_click_wherever_it_is(question):
    screen = shown(question)
    assert screen.point(0.1, 0.2, 0.5, dragged=False) is None  # not at the start
    assert screen.point(-0.1, 0.2, 1.0, dragged=False) is None
    assert screen.point(0.09, 0.1, 1.1, dragged=True) is None
    found = Selection.of(screen.point(0.08, 0.1, 1.4, dragged=False).value)
    assert found == pytest.approx((24.0, 30.0, 0.4))


def test_a_measured_finger_is_a_cursor_and_the_key_selects_it(question):
    discs = replace(question, bars=False)
    screen = shown(discs)
    assert screen.press(" ", 0.2) is None  # no finger yet
    screen.see(-31.0, 1.0)
    assert sum(isinstance(item, Disc) for item in screen.scene(0.3)) == 3
    assert screen.press(" ", 0.5) is None
    screen.see(29.0, -1.0)
    assert Selection.of(screen.press(" ", 0.9).value) == pytest.approx((29.0, -1.0, 0.4))


def test_what_comes_next_is_coloured_and_the_limit_ends_it(question):
    screen = shown(question, time_limit_s=2.0)
    colours = [item.colour for item in screen.scene(0.0) if isinstance(item, Box)][:2]
    screen.point(-0.1, 0.0, 1.0, dragged=False)
    assert colours == ["accent", "quiet"]
    after = [item.colour for item in screen.scene(1.1) if isinstance(item, Box)][:2]
    assert after == ["quiet", "accent"]
    assert screen.point(0.1, 0.0, 2.5, dragged=False) is None
    assert screen.expire(2.0).timed_out


def test_the_table_states_hit_and_miss_and_a_timed_out_movement_is_repeated_once(plan):
    made = plan(POINTING_2023)
    steps = PROTOCOL.steps(
        made.study.tasks[0], replace(made.context("pointing"), texts=made.texts())
    )
    step, timed_out = next(steps), Reply(timed_out=True)
    while not isinstance(step, Ask):
        step = steps.send(None)
    answers = {"selection": {"value": Selection(step.question.target_mm[0] + 5.5, 0, 0.4).value}}
    record = TrialRecord(trial=step.trial, answers=answers)
    assert PROTOCOL.response["selection"].value(record) == "outside"
    assert PROTOCOL.response["movement_time"].value(record) == 0.4
    repeats = []
    while len(repeats) < 7:
        step = steps.send(timed_out if isinstance(step, Ask) else Voided())
        if isinstance(step, EndTrial):
            repeats.append(step.trial.repeats)
    assert repeats == [None] * 5 + [1, 2]
