"""A passive stage: where it is, what it refuses, and that it stops."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.motion import travelled
from slipscale.hardware.contact.registry import open_source
from slipscale.hardware.contact.source import SensorFault, Surroundings
from slipscale.hardware.contact.stage import Strokes

SLOW = Strokes(speed_mm_s=50.0, length_mm=40.0)


@pytest.fixture
def clock():
    return VirtualClock()


def opened(clock, options=""):
    stage = open_source("position", f"emulated_stage{options}", Surroundings(clock=clock))
    stage.connect()
    stage.begin()
    return stage


def run(stage, clock, seconds):
    """Take samples every 10 ms, as a session does at every frame."""
    samples = []
    for _ in range(round(seconds / 0.01)):
        clock.sleep(0.01)
        samples += stage.take()
    return samples


@given(st.floats(0, 100), st.floats(0, 100), st.floats(1, 300), st.floats(100, 10_000))
def test_a_movement_ends_where_it_should_within_speed_and_acceleration(start, end, speed, ramp):
    motion = travelled(2.0, start, end, speed_mm_s=speed, acceleration_mm_s2=ramp)
    assert motion.state(motion.ends_s)[0] == pytest.approx(end, abs=1e-6)
    assert max(abs(acceleration) for _, acceleration in motion.parts) == ramp
    steps = [2.0 + n / 100 * (motion.ends_s - 2.0) for n in range(101)]
    assert max(abs(motion.state(each)[1]) for each in steps) <= speed * (1 + 1e-6)
    assert all(min(start, end) - 1e-6 <= motion.state(each)[0] <= max(start, end) + 1e-6
               for each in steps)  # fmt: skip


def test_strokes_go_back_and_forth_at_the_commanded_speed(clock):
    stage = opened(clock, ":acceleration=2000")
    stage.stroke(SLOW)
    samples = run(stage, clock, 1.7)  # 0.825 s a stroke
    places = {round(each.time_s, 2): each.values[0] for each in samples}
    assert max(places.values()) == pytest.approx(40, abs=0.3)
    assert places[0.5] - places[0.4] == pytest.approx(5.0, abs=0.01)
    assert places[1.3] - places[1.2] == pytest.approx(-5.0, abs=0.01)
    assert len(samples) == 171


@pytest.mark.parametrize("direction, start, end", [("forward", 0, 40), ("backward", 40, 0)])
def test_with_a_direction_there_is_one_stroke_from_its_start(clock, direction, start, end):
    stage = opened(clock)
    strokes = Strokes(speed_mm_s=50.0, length_mm=40.0, direction=direction)
    stage.home(strokes, lambda: None)
    stage.begin()
    stage.stroke(strokes)
    samples = run(stage, clock, 2.0)
    assert samples[0].values[0] == pytest.approx(start)
    assert samples[-1].values[0] == pytest.approx(end)


def test_a_session_that_no_longer_takes_samples_leaves_the_stage_at_the_end_of_its_stroke(clock):
    stage = opened(clock)
    stage.stroke(SLOW)
    clock.sleep(10.0)
    assert stage.place_at(clock.now()) == 40.0


@pytest.mark.parametrize("end", ["stop", "close"])
def test_it_stops_within_its_braking_distance(clock, end):
    stage = opened(clock, ":acceleration=1000")
    stage.stroke(SLOW)
    run(stage, clock, 0.4)
    before = stage.place_at(clock.now())
    getattr(stage, end)()
    run(stage, clock, 1.0)
    assert stage.place_at(clock.now()) - before == pytest.approx(50**2 / 2000, abs=1e-6)


def test_an_obstacle_is_a_fault_and_home_is_reached_afterwards(clock):
    stage = opened(clock, ":blocked=25")
    stage.stroke(SLOW)
    with pytest.raises(SensorFault, match=r"stopped at 25\.0 mm instead of 40\.0 mm"):
        run(stage, clock, 2.0)
    stage.stop()
    looks = []
    stage.home(SLOW, lambda: looks.append(clock.now()))
    assert stage.place_at(clock.now()) == pytest.approx(0.0)
    assert len(looks) > 10


@pytest.mark.parametrize(
    "options, message",
    [(":travel=30", "exceed its travel of 30 mm"), (":speed=40", "maximum speed of 40 mm/s")],
)
def test_strokes_beyond_its_limits_are_refused_before_it_moves(clock, options, message):
    stage = opened(clock, options)
    for act in (lambda: stage.stroke(SLOW), lambda: stage.home(SLOW, lambda: None)):
        with pytest.raises(UserError, match=message):
            act()
    assert stage.place_at(clock.now() + 1) == 0.0


@pytest.mark.parametrize("presses, commanded", [(True, [0.6]), (False, [])])
def test_a_stage_that_presses_has_the_force_before_it_moves(clock, monkeypatch, presses, commanded):
    stage = opened(clock)
    told = []
    monkeypatch.setattr(type(stage), "presses", presses)
    monkeypatch.setattr(stage, "_press", told.append, raising=False)
    monkeypatch.setattr(stage, "_go", lambda *_: told.append("go"))
    stage.stroke(replace(SLOW, normal_n=0.6))
    stage.stroke(SLOW)  # the participant's own force
    assert told == [*commanded, "go", "go"]
