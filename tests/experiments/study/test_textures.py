"""Textures in a study: written down, presented, felt, interrupted, and in the data set."""

import json

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.schema import columns
from slipscale.experiments.journal.serialisation import step_record, surface_from
from slipscale.experiments.protocol_parts.registry import load_protocol
from slipscale.experiments.running import lab_session
from slipscale.experiments.running.lab_session import Setting, make_plan
from slipscale.experiments.running.preflight import PlannedSession, check_plate
from slipscale.experiments.session.followed_textures import Following
from slipscale.experiments.session.surface_state import SurfaceState
from slipscale.experiments.steps.steps import Explore, Present
from slipscale.experiments.study.file import parse_study, study_text
from slipscale.faults import UserError
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.errors import NotReached
from slipscale.hardware.plate.twin import OFF
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.texture import Grating

RIDGES = """
[[textures]]
name = "ridges"
spatial_period_mm = 2.5
waveform = "square"
mean_um_pp = 1.2
depth_um_pp = 0.8
finger_speed_mm_s = 50.0
"""
STUDY = f"""
name = "textured"
title = "Textured"
amplitudes_um_pp = [0.0, 2.0]
{RIDGES}
[[tasks]]
protocol = "descending_difference"
[[tasks]]
protocol = "magnitude_estimation"
"""
GRATING = Grating(
    name="ridges",
    label="T1",
    spatial_period_mm=2.5,
    waveform="square",
    mean_level=1.2,
    depth_level=0.8,
    finger_speed_mm_s=50.0,
)


@pytest.fixture
def textured(plan):
    return plan(study_text("textures_demo"), study_name="textures_demo", seed=44)


def rows(folder, task="magnitudeestimation"):
    (path,) = folder.glob(f"sub-*/beh/*_task-{task}_*_beh.tsv")
    header, *lines = [line.split("\t") for line in path.read_text().splitlines()]
    return header, [dict(zip(header, line, strict=True)) for line in lines]


def files(folder):
    return {
        path.relative_to(folder): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and "sourcedata" not in path.parts
    }


def test_a_texture_is_read_as_it_is_written():
    assert parse_study(STUDY, "textured.toml").texture_surfaces == (GRATING,)


def test_every_fault_of_the_textures_is_told_at_once():
    bad = STUDY.replace("depth_um_pp = 0.8", "depth_um_pp = 1.4") + "".join(
        RIDGES.replace('"ridges"', name).replace(old, new)
        for name, old, new in (
            ('"fast"', "= 50.0", "= 500.0"),
            ('"odd"', '"square"', '"zigzag"'),
            ('"still"', "= 50.0", "= 0.0"),
            ('"a b"', "waveform", "wave_form"),
            ('"whence"', "finger_speed_mm_s = 50.0", ""),
        )
    )
    with pytest.raises(UserError) as caught:
        parse_study(bad, "bad.toml")
    message = str(caught.value)
    for part in (
        "bad.toml has 7 faults",
        ("line 6, item 1 of textures: texture 'ridges': depth must be at most the mean"),
        "item 2 of textures: texture 'fast': a finger at 500 mm/s crosses 200 periods per second",
        (
            "waveform of item 3 of textures: expected 'sine', 'square', 'triangle' or "
            "'sawtooth', got 'z"
        ),
        "finger_speed_mm_s of item 4 of textures: expected a number above 0, got 0.0",
        "name of item 5 of textures: expected letters, digits and _",
        "wave_form of item 5 of textures: unknown key",
        "finger_speed_mm_s of item 6 of textures: is missing",
    ):
        assert part in message


@pytest.mark.parametrize(
    "old, new, complaint",
    [
        (
            "mean_um_pp = 1.2",
            "mean_um_pp = 1.8",
            r"item 1 of textures: 2\.6 is beyond the plate's 2\.5 µm",
        ),
        (
            "[[tasks]]",
            f"{RIDGES}[[tasks]]",
            "name of item 2 of textures: there is already a 'ridges'",
        ),
        (
            '[[tasks]]\nprotocol = "magnitude_estimation"',
            "",
            "line 6, item 1 of textures: no task presents textures",
        ),
    ],
)
def test_textures_must_be_distinct_presented_and_within_the_plate(old, new, complaint):
    with pytest.raises(UserError, match=complaint):
        parse_study(STUDY.replace(old, new, 1), "study.toml")


@pytest.mark.parametrize("surface", [GRATING, VirtualSurface(level=1.2, label="S1")])
def test_a_step_record_gives_its_surface_back(surface):
    record = json.loads(json.dumps(step_record(Present(surface=surface))))
    assert surface_from(record["surface"]) == surface


def test_estimation_presents_textures_among_the_surfaces_and_the_descent_does_not(laboratory, plan):
    laboratory.run(plan(STUDY, study_name="textured"))
    build_dataset(laboratory.folder)
    header, estimated = rows(laboratory.folder)
    assert header[header.index("surface") + 1] == "texture"
    for phase in ("practice", "main"):
        assert sorted(
            (row["surface"], row["texture"], row["amplitude_um_pp"])
            for row in estimated
            if row["phase"] == phase
        ) == [("S1", "n/a", "0"), ("S2", "n/a", "2"), ("T1", "ridges", "2")]
    header, descended = rows(laboratory.folder, "descendingdifference")
    assert "texture" not in header
    assert {row["surface"] for row in descended} == {"S1", "S2"}


def test_the_sidecar_says_what_the_columns_hold_for_a_texture():
    described = columns(load_protocol("magnitude_estimation"))
    assert "texture" in described["texture"].description
    assert described["amplitude_um_pp"].description.endswith("for a texture, the largest")
    assert "; for a texture, its mean; n/a" in described["amplitude_readback_um_pp"].description


def test_a_texture_feels_like_its_mean_and_not_like_its_largest_amplitude(laboratory, plan):
    laboratory.run(plan(STUDY, study_name="textured"))
    build_dataset(laboratory.folder)
    _, estimated = rows(laboratory.folder)
    for row in estimated:
        if row["texture"] == "ridges":
            assert float(row["amplitude_readback_um_pp"]) == pytest.approx(1.2, abs=0.03)
    laboratory.plate.connect()
    laboratory.plate.present(GRATING)
    laboratory.person.perform(Explore(text=""), lambda: None)
    (felt,) = laboratory.person.respondent.felt_level
    assert felt == pytest.approx(1.2, abs=0.2)


def test_wherever_a_textured_pilot_is_interrupted_its_data_come_out_the_same(
    laboratory, tmp_path, textured
):
    whole = laboratory.folder = tmp_path / "whole"
    laboratory.run(textured)
    build_dataset(whole)
    expected = files(whole)
    lines = textured.journal_path(whole).read_bytes().splitlines(keepends=True)
    for kept in range(1, len(lines), 4):
        laboratory.folder = tmp_path / f"cut{kept}"
        path = textured.journal_path(laboratory.folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:kept]) + lines[kept][: kept % 7])
        assert laboratory.run(textured) == "complete"
        build_dataset(laboratory.folder)
        assert files(laboratory.folder) == expected, f"cut after record {kept - 1}"


@pytest.mark.parametrize("depth_level", [0.5, 1.2])
def test_a_texture_that_has_gone_is_noticed_even_where_it_reaches_down_to_zero(depth_level):
    clock = VirtualClock()
    plate = MockPlate(clock=clock)
    plate.connect()
    stage = SurfaceState(plate, clock, lambda _: None, Following(plate, clock))
    steady = Grating(spatial_period_mm=2.5, mean_level=1.2, depth_level=depth_level, label="T1")
    stage.present(Present(surface=steady))
    for _ in range(50):
        clock.sleep(0.0037)
        stage.confirm()
    plate.twin.set_drive(OFF, clock.now())
    clock.sleep(0.05)
    with pytest.raises(NotReached, match=r"1\.2 µm p-p was commanded, but 0\.0"):
        stage.confirm()


@pytest.fixture
def rigid(monkeypatch):
    """Have the mock hold one amplitude, as a function generator does."""
    monkeypatch.setattr(MockPlate, "modulator", property(lambda _: None, lambda *_: None))


@pytest.mark.usefixtures("rigid")
def test_a_plate_that_cannot_modulate_is_found_out_before_the_session(tmp_path):
    planned = PlannedSession(study="textures_demo", plate="mock", out=tmp_path)
    with pytest.raises(UserError, match="cannot present the texture 'T1'"):
        check_plate(planned)
    plan = make_plan("textures_demo", participant="01", pilot=True)
    with pytest.raises(UserError, match="cannot present the texture 'T1'"):
        lab_session.begin(tmp_path, plan, Setting(plate="mock"))
    assert not plan.journal_path(tmp_path).exists()


def test_check_of_a_plate_that_can_modulate_finds_nothing(tmp_path):
    assert check_plate(PlannedSession(study="textures_demo", plate="mock", out=tmp_path)).passed
