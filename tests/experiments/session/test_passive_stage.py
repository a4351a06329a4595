"""Sessions with a passive stage: it strokes while the participant explores, and stops otherwise."""

import json

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.running.contact_sources import ContactSpecs
from slipscale.experiments.running.pilot import run_simulated
from slipscale.experiments.session.passive_exploration import moved
from slipscale.experiments.steps.steps import Explore, Guide
from slipscale.experiments.study.file import parse_study
from slipscale.faults import UserError
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.source import SensorFault, Surroundings
from slipscale.hardware.contact.stage import EmulatedStage
from slipscale.hardware.errors import ConnectionLost
from tests.experiments.session.test_stroke import rows

STUDY = """
name = "passive"
title = "A stage strokes"
seed = 3
participants = 1
[plate]
position = "lasers:/dev/nowhere"
force = "load_cells:/dev/nowhere"
[stroke]
passive = true
speed_mm_s = 50.0
[[textures]]
name = "edge"
kind = "transient"
from_um_pp = 0.5
to_um_pp = 2.0
transition_s = 0.01
position_mm = 10.0
[[textures]]
name = "ridges"
spatial_period_mm = 5.0
mean_um_pp = 1.0
depth_um_pp = 0.5
finger_speed_mm_s = 50.0
[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0
"""
GUIDE = Guide(
    speed_mm_s=50.0, normal_force_n=None, direction="any", stroke_mm=40.0, pacer=False, passive=True
)


@pytest.fixture(scope="module")
def made_plan(request):
    return request.getfixturevalue("plan")(STUDY, seed=3, study_name="passive")


@pytest.fixture(scope="module")
def whole(tmp_path_factory, made_plan):
    folder = tmp_path_factory.mktemp("whole")
    run_simulated(folder, made_plan, "mock")
    build_dataset(folder)
    return folder


def test_the_stage_s_place_is_the_finger_s_in_the_data_and_triggers_changes(whole, made_plan):
    found = {row["texture"]: row for row in rows(whole)}
    for row in found.values():
        assert float(row["exploration_speed_mm_s"]) == pytest.approx(50, abs=3)
        assert row["stroke"] == "within"
        assert float(row["friction_coefficient"]) > 0
    strokes = float(found["edge"]["strokes"])
    assert float(found["edge"]["changes"]) == (strokes + 1) // 2  # on each way forth
    text = made_plan.journal_path(whole).read_text("utf-8")
    assert '"text":"Keep your finger still."' in text


def test_wherever_a_pilot_is_cut_the_stage_gives_the_same_data(whole, made_plan, tmp_path):
    lines = made_plan.journal_path(whole).read_bytes().splitlines(keepends=True)
    kinds = [json.loads(line)["kind"] for line in lines]
    contacts = [number for number, kind in enumerate(kinds) if kind == "contact"]
    for cut in (contacts[0], contacts[0] + 1, contacts[-1] + 2):
        folder = tmp_path / str(cut)
        path = made_plan.journal_path(folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:cut]))
        run_simulated(folder, made_plan, "mock")
        build_dataset(folder)
        assert rows(folder) == rows(whole)


def test_a_blocked_stage_is_a_fault_of_the_session(made_plan, tmp_path):
    blocked = ContactSpecs(position="emulated_stage:blocked=20", force="none")
    with pytest.raises(SensorFault, match=r"stopped at 20\.0 mm instead of 40\.0 mm"):
        run_simulated(tmp_path, made_plan, "mock", blocked)


@pytest.mark.parametrize("error", [ConnectionLost("gone"), KeyboardInterrupt()])
def test_whatever_ends_an_exploration_stops_the_stage(error):
    clock = VirtualClock()
    stage = EmulatedStage(Surroundings(clock=clock))

    def explore():
        with moved(stage, Explore(text="", guide=GUIDE), lambda: None):
            clock.sleep(0.4)
            raise error

    with pytest.raises(type(error)):
        explore()
    clock.sleep(0.1)
    place = stage.place_at(clock.now())
    clock.sleep(5)
    assert 15 < place == stage.place_at(clock.now()) < 25


def test_after_an_exploration_the_stage_is_at_its_start():
    clock = VirtualClock()
    stage = EmulatedStage(Surroundings(clock=clock))
    with moved(stage, Explore(text="", guide=GUIDE), lambda: None) as watch:
        for _ in range(120):  # 0.825 s a stroke
            clock.sleep(0.01)
            watch()
        assert stage.place_at(clock.now()) == pytest.approx(22, abs=2)  # on its way back
    assert stage.place_at(clock.now()) == pytest.approx(0)


@pytest.mark.parametrize(
    "position, passive, message",
    [
        ("simulated", True, "no stage measures the position"),
        ("emulated_stage:travel=30", True, "exceed its travel of 30 mm"),
        ("emulated_stage", False, "expected passive = true"),
    ],
)
def test_passive_strokes_and_a_stage_need_each_other(plan, tmp_path, position, passive, message):
    text = STUDY if passive else STUDY.replace("passive = true\n", "")
    specs = ContactSpecs(position=position if ":" in position else f"{position}:rate=100")
    with pytest.raises(UserError, match=message):
        run_simulated(tmp_path, plan(text, seed=3), "mock", specs)


@pytest.mark.parametrize("line", ["\nspeed_mm_s = 50.0", '\nposition = "lasers:/dev/nowhere"'])
def test_passive_strokes_need_a_speed_and_a_position(line):
    with pytest.raises(
        UserError, match="expected speed_mm_s, and a stage as the value of position"
    ):
        parse_study(STUDY.replace(line, ""), "passive")
