"""What the finger does is measured, survives what a session survives, and textures follow it."""

import gzip
import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest

from slipscale.commands import main
from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.dataset.measured import samples
from slipscale.experiments.dataset.rows_from_journal import gather
from slipscale.experiments.dataset.verification import verify
from slipscale.experiments.journal.journal import Journal
from slipscale.experiments.journal.plan_and_progress import read_plan
from slipscale.experiments.journal.reading import read_records
from slipscale.experiments.journal.record_shapes import checked
from slipscale.experiments.participants.base import StopRequested
from slipscale.experiments.participants.simulated_people.finger import SimulatedFinger
from slipscale.experiments.participants.simulated_people.in_session import SimulatedParticipant
from slipscale.experiments.participants.simulated_people.respondent import respondent_of
from slipscale.experiments.running.begin_or_resume import run_plan
from slipscale.experiments.running.contact_sources import ContactSpecs, NamedSource
from slipscale.experiments.running.pilot import run_pilot, run_simulated
from slipscale.experiments.session.operator import UnattendedOperator
from slipscale.experiments.session.parts import Setup
from slipscale.experiments.session.resonance_tracking import ResonanceTracking
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.hardware.address import Plate
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.calibration.record import Calibration
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.followed_texture import FollowedTexture
from slipscale.hardware.contact.measures import friction
from slipscale.hardware.contact.registry import open_source
from slipscale.hardware.contact.simulated import SimulatedPosition
from slipscale.hardware.contact.source import Sample, SensorFault, Surroundings
from slipscale.hardware.plate.dynamics import Resonator
from slipscale.hardware.plate.twin import Twin
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.texture import Grating

STUDY = """
name = "finger"
title = "A finger that is measured"
seed = 3
participants = 1
amplitudes_um_pp = [0.0, 2.3]

[plate]
position = "lasers:/dev/nowhere"
force = "load_cells:/dev/nowhere"

[[textures]]
name = "waves"
spatial_period_mm = 10.0
mean_um_pp = 1.2
depth_um_pp = 0.8
finger_speed_mm_s = 50.0

[[tasks]]
protocol = "magnitude_estimation"
repetitions = 1
practice = 0
randomisation = "blocked"
"""
PLAIN = STUDY.replace(STUDY[STUDY.index("[[textures]]") : STUDY.index("[[tasks]]")], "")
UNNAMED = PLAIN[: PLAIN.index("[plate]")] + PLAIN[PLAIN.index("[[tasks]]") :]
MEASURED = ("exploration_speed_mm_s", "strokes", "friction_coefficient", "normal_force_n")


def rows(folder):
    [table] = folder.glob("sub-01/beh/*_beh.tsv")
    header, *lines = table.read_text(encoding="utf-8").splitlines()
    return [dict(zip(header.split("\t"), line.split("\t"), strict=True)) for line in lines]


@pytest.fixture(scope="module")
def whole(tmp_path_factory, plans):
    """Return the folder of a pilot that nothing interrupted."""
    folder = tmp_path_factory.mktemp("whole")
    run_pilot(folder, [plans()], tell=lambda _: None)
    return folder


@pytest.fixture(scope="module")
def plans():
    def make(text=STUDY, **changes):
        return RunPlan(
            **{"study_name": "finger", "study_text": text, "participant": "01", "seed": 3,
               "language": "en", "mode": "pilot"} | changes
        )  # fmt: skip

    return make


def test_a_pilot_simulates_what_the_study_measures(whole):
    found = rows(whole)
    for row in found:
        assert 20 < float(row["exploration_speed_mm_s"]) < 200
        assert float(row["strokes"]) >= 1
        assert 0.1 < float(row["normal_force_n"]) < 2
    coefficient = {row["amplitude_um_pp"]: float(row["friction_coefficient"]) for row in found}
    assert coefficient["0"] == pytest.approx(0.8, abs=0.02)
    assert coefficient["2.3"] < 0.75
    [sidecar] = whole.glob("sub-01/beh/*_beh.json")
    contact = json.loads(sidecar.read_text())["Slipscale"]["contact"]
    assert contact["textures"] == "follow the finger"
    assert contact["position"]["spec"] == "simulated"


def test_columns_are_those_of_what_was_measured_and_are_described(whole, plans, tmp_path):
    described = json.loads(next(whole.glob("task-*_beh.json")).read_text())
    assert set(MEASURED) <= set(rows(whole)[0])
    assert {described[name].get("Units") for name in MEASURED} == {"mm/s", "N", None}
    specs = ContactSpecs(position="none")
    run_pilot(tmp_path, [plans()], contact=specs, tell=lambda _: None)
    assert set(MEASURED) & set(rows(tmp_path)[0]) == {"friction_coefficient", "normal_force_n"}


def test_answers_do_not_depend_on_whether_the_finger_is_measured(whole, plans, tmp_path):
    # Without textures: one that is followed feels otherwise.
    for name, specs in {
        "with": None,
        "without": ContactSpecs(position="none", force="none"),
    }.items():
        run_pilot(tmp_path / name, [plans(PLAIN)], contact=specs, tell=lambda _: None)
    with_, without = rows(tmp_path / "with"), rows(tmp_path / "without")
    assert [row["estimate"] for row in with_] == [row["estimate"] for row in without]


def test_a_run_that_is_killed_anywhere_and_resumed_measures_what_a_whole_one_did(
    whole, plans, tmp_path
):
    plan = plans()
    lines = plan.journal_path(whole).read_bytes().splitlines(keepends=True)
    expected = [
        {name: row[name] for name in (*MEASURED, "estimate", "exploration_time")}
        for row in rows(whole)
    ]
    kinds = [json.loads(line)["kind"] for line in lines]
    cuts = [n for n, kind in enumerate(kinds) if kind == "contact"]
    for cut in (cuts[0], cuts[0] + 1, cuts[1] + 1, cuts[len(cuts) // 2], cuts[-1] + 1):
        folder = tmp_path / str(cut)
        path = plan.journal_path(folder)
        path.parent.mkdir(parents=True)
        path.write_bytes(b"".join(lines[:cut]))
        run_simulated(folder, plan, "mock")
        build_dataset(folder)
        found = [{name: row[name] for name in expected[0]} for row in rows(folder)]
        assert found == expected


def test_positions_and_forces_are_time_series_that_agree_with_the_journal(whole, plans, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(whole, folder)
    stem = folder / "sub-01/beh/sub-01_task-magnitudeestimation_run-01_recording-position_physio"
    path, told = stem.with_suffix(".tsv.gz"), json.loads(stem.with_suffix(".json").read_text())
    assert told["Columns"] == ["x_mm", "y_mm", "trial"]
    table = [line.split("\t") for line in gzip.decompress(path.read_bytes()).decode().splitlines()]
    records, _ = read_records(plans().journal_path(whole))
    places = [
        (each, record.data["trial"])
        for record in records
        if record.kind == "contact" and record.data["source"] == "position"
        for each in samples(record)
    ]
    assert told["StartTime"] == pytest.approx(places[0][0].time_s)
    for sample, trial in places[:: len(places) // 20]:
        row = table[round((sample.time_s - told["StartTime"]) * told["SamplingFrequency"])]
        assert row[2] == str(trial)
        assert float(row[0]) == pytest.approx(sample.values[0], abs=1.0)
    assert ["n/a"] * 3 in table
    assert verify(folder) == []
    path.write_bytes(gzip.compress(b"0\t0\t1\n"))
    assert [each.what for each in verify(folder)] == ["differs from the journals"]
    path.write_bytes(b"not compressed")
    assert "cannot be read" in verify(folder)[0].what


def test_falls_of_friction_are_counted_as_slips_without_touch_down_and_lift_off():
    saw = [0.5 + 0.05 * (n % 10) for n in range(200)]  # falls from 0.95 to 0.5, ten times a second
    forces = [Sample(n / 100, (1.0, ratio)) for n, ratio in enumerate(saw)]
    ends = [Sample(2 + n / 100, (0.1, 0.1 * (n % 2))) for n in range(20)]
    found = friction([*forces, *ends])
    assert found.slip_rate_hz == pytest.approx(19 / 2.19)
    assert found.slip_depth_share == pytest.approx(1 - 0.5 / 0.95, abs=1e-6)
    assert friction([Sample(n / 100, (1.0, 0.5)) for n in range(20)]).slip_depth_share is None


def test_the_samples_are_in_the_journal_and_under_its_hash(whole, plans):
    path = plans().journal_path(whole)
    records, _ = read_records(path)
    places = [s for r in records if r.kind == "contact" and r.data["source"] == "position"
              for s in samples(r)]  # fmt: skip
    assert len(places) > 500
    path.with_name("copy").write_bytes(
        path.read_bytes().replace(b'"times_s":[0.0,', b'"times_s":[0.1,', 1)
    )
    with pytest.raises(UserError, match="damaged"):
        read_records(path.with_name("copy"))


@pytest.mark.parametrize(
    "change",
    [
        {"source": "smell"},
        {"times_s": [0.0]},
        {"values": {"x_mm": [1.0, 2.0]}},
        {"values": {"normal_n": [1.0, 2.0], "lateral_n": [1.0, 2.0]}},
        {"ends": "perhaps"},
    ],
)
def test_a_record_that_holds_something_else_is_damage(whole, plans, change):
    records = read_plan(plans().journal_path(whole))[1]
    number = next(
        n for n, r in enumerate(records) if r.kind == "contact" and r.data["source"] == "position"
    )
    wrong = replace(records[number], data={**records[number].data, **change})
    _, damage = checked([*records[:number], wrong, *records[number + 1 :]])
    assert damage[0].line == number + 1


def test_an_exploration_that_was_broken_off_counts_for_no_trial(whole, plans):
    records = read_plan(plans().journal_path(whole))[1]
    place = next(
        n for n, r in enumerate(records) if r.kind == "contact" and r.data["ends"] == "whole"
    )
    torn = replace(records[place], data={**records[place].data, "ends": "broken off",
                                         "values": {"x_mm": [9e9] * 2, "y_mm": [0.0] * 2},
                                         "times_s": [0.0, 0.1]})  # fmt: skip
    again = gather([*records[:place], torn, *records[place:]])
    assert [t.measured for t in again.trials["magnitudeestimation"]] == [
        t.measured for t in gather(records).trials["magnitudeestimation"]
    ]


def test_a_sensor_that_goes_away_is_a_fault_that_is_recovered_from(plans, tmp_path, monkeypatch):
    take, calls = SimulatedPosition.take, []

    def lost_once(self):
        calls.append(1)
        if len(calls) == 50:
            raise SensorFault("the cable")
        return take(self)

    monkeypatch.setattr(SimulatedPosition, "take", lost_once)
    run_pilot(tmp_path, [plans()], tell=lambda _: None)
    records = read_plan(plans().journal_path(tmp_path))[1]
    assert [r.data["code"] for r in records if r.kind == "fault"] == ["sensor"]
    assert [r.data["ends"] for r in records if r.kind == "contact"].count("broken off") == 2
    found = rows(tmp_path)
    assert [("fault" in row["flag"]) for row in found].count(True) == 1
    assert all(float(row["strokes"]) >= 1 for row in found)


def test_a_stop_in_an_exploration_keeps_what_was_measured_until_then(plans, tmp_path, monkeypatch):
    monkeypatch.setattr(SimulatedFinger, "lifts", lambda _: (_ for _ in ()).throw(StopRequested()))
    run_simulated(tmp_path, plans(), "mock")
    records = read_plan(plans().journal_path(tmp_path))[1]
    ends = [(r.data["source"], r.data["ends"]) for r in records if r.kind == "contact"]
    assert ends == [("position", "broken off"), ("force", "broken off")]
    assert len(next(r.data["times_s"] for r in records if r.kind == "contact")) > 50


# Textures -------------------------------------------------------------------------------------

WAVES = Grating(spatial_period_mm=10.0, mean_level=1.2, depth_level=0.8)


@pytest.mark.parametrize("speed_mm_s", [-80.0, 30.0, 120.0])
def test_a_texture_is_that_of_the_place_where_the_finger_will_be(speed_mm_s):
    follower = FollowedTexture(WAVES, lag_s=0.02)
    for frame in range(20):
        now_s = frame * 0.01
        follower.see([Sample(now_s, (speed_mm_s * now_s, 0.0))])
        due = follower.level(now_s)
    ahead_mm = speed_mm_s * (now_s + 0.02 + 0.005)  # the lag, and half of a frame
    assert due == pytest.approx(WAVES.level_at(ahead_mm), abs=1e-9)


def test_a_finger_that_rests_feels_one_place_and_one_that_is_lost_the_mean():
    follower = FollowedTexture(WAVES, lag_s=0.02)
    for frame in range(20):
        follower.see([Sample(frame * 0.01, (2.5, 0.0))])
        due = follower.level(frame * 0.01)
    assert due == pytest.approx(2.0)  # a ridge
    assert follower.level(1.0) == 1.2


def test_the_plate_makes_the_texture_at_the_fingers_place(laboratory, plan):
    """Whatever its speed: the simulated finger turns at the ends of its stroke."""
    pairs = []

    class Looks(SimulatedPosition):
        def take(self):
            new = super().take()
            if new and laboratory.plate.twin.drive.target_um_pp:
                pairs.append((new[-1].values[0], laboratory.plate.vibration_level()))
            return new

    text = STUDY.replace("[0.0, 2.3]", "[0.0]").replace("lasers:/dev/nowhere", "simulated:noise=0")
    errors = followed_errors(laboratory, plan(text, seed=3), Looks, pairs)
    assert len(errors) > 200
    assert sorted(errors)[len(errors) // 2] < 0.05 * 0.8
    assert max(errors) < 0.35 * 0.8  # where it moves fastest, the command is a frame old


def followed_errors(laboratory, a_plan, looks, pairs):
    """Run a study with one texture; return how far the plate was from the grating each time."""
    clock = VirtualClock()
    plate = laboratory.plate = open_plate("mock:noise=0", clock=clock, seed=3)
    path = a_plan.journal_path(laboratory.folder)
    with Journal.create(path, clock) as journal, plate:
        person = SimulatedParticipant(
            respondent_of(a_plan), feel=plate.vibration_level, clock=clock, frame_s=0.002
        )
        source = looks(Surroundings(clock=clock, finger=person.finger), rate_hz=500.0, noise=0.0)
        run_plan(
            a_plan,
            Setup(plate=plate, participant=person, journal=journal, clock=clock,
                  operator=UnattendedOperator()),
            spec="mock",
            sources={"position": NamedSource(spec="simulated", source=source)},
        )  # fmt: skip
    return [abs(amplitude - WAVES.level_at(place)) for place, amplitude in pairs]


# Commands -------------------------------------------------------------------------------------


def test_a_pilot_refuses_sources_that_measure(capsys, tmp_path):
    words = ["pilot", "--participants", "1", "--out", str(tmp_path / "p")]
    assert main([*words, "--position", "lasers:COM3"]) == 2
    assert "a pilot runs in virtual time; expected simulated" in capsys.readouterr().err


def test_check_tells_what_a_source_reads(capsys, tmp_path):
    way = tmp_path / "way.csv"
    way.write_text("time_s,x_mm,y_mm\n0,1.5,0\n")
    words = ["check", "--position", f"scripted:{way}", "--force", "simulated", "--json"]
    main([*words, "--out", str(tmp_path / "data")])
    finger = next(f for f in json.loads(capsys.readouterr().out) if f["name"] == "finger")
    assert finger["passed"]
    assert "position: " in finger["detail"]
    assert "x_mm 1.5" in finger["detail"]
    assert "force: simulated can be tested only during a session" in finger["detail"]


def test_the_plates_file_names_sources_after_command_and_study(tmp_path, capsys, plans):
    way, file = tmp_path / "way.csv", tmp_path / "desk.toml"
    way.write_text("time_s,x_mm,y_mm\n0,1.5,0\n")
    main(["plate", "new", str(file), "--backend", "mock"])
    wired = f'[wiring]\nposition = "scripted:{way}"\nforce = "load_cells:/dev/nowhere"'
    file.write_text(file.read_text().replace("[wiring]", wired))
    assert main(["plate", "sign", str(file)]) == 0
    run_simulated(tmp_path / "data", plans(UNNAMED), f"mock:plate={file}")
    header = read_plan(plans().journal_path(tmp_path / "data"))[1][0].data
    assert header["contact"]["position"]["spec"] == f"scripted:{way}"
    assert header["contact"]["force"]["spec"] == "simulated"  # in place of what a pilot lacks
    words = ["check", "--plate", f"mock:plate={file}", "--force", "none", "--json"]
    capsys.readouterr()
    main([*words, "--out", str(tmp_path / "other")])
    finger = next(f for f in json.loads(capsys.readouterr().out) if f["name"] == "finger")
    assert "x_mm 1.5" in finger["detail"]
    assert "force" not in finger["detail"]


def test_check_says_nothing_of_the_finger_where_nothing_measures_it(capsys, tmp_path):
    main(["check", "--json", "--out", str(tmp_path / "data")])
    assert "finger" not in [f["name"] for f in json.loads(capsys.readouterr().out)]


def test_a_window_without_a_pointer_is_told_before_it_opens():
    around = Surroundings(clock=SimpleNamespace(now=lambda: 0.0))
    with pytest.raises(UserError, match="no window"):
        open_source("position", "mouse:mm_per_pixel=1", around)


# Resonance tracking ---------------------------------------------------------------------------


def calibration():
    point = {"sweep": "voltage", "frequency_hz": 30_500, "voltage_v": 16.5, "amplitude_um_pp": 2.5}
    return Calibration.model_validate(
        {
            "device": {"serial": "twin", "backend": "mock"},
            "made": {"date": "2026-11-21", "by": "a test", "instrument": "none"},
            "drive": {},
            "resonance": {
                "frequency_hz": 30_500, "frequency_ci95_hz": 1, "residual_um": 0,
                "quality_factor": 60, "quality_factor_ci95": 1,
            },
            "gain": {
                "um_pp_per_v": 2.3 / 15, "um_pp_per_v_ci95": 0, "residual_um": 0,
                "voltage_max_v": 16.5, "amplitude_max_um_pp": 2.5,
            },
            "points": [point],
        }
    )  # fmt: skip


class Generator(MockPlate):
    """A plate that is driven where it is told, as by a generator; with an instrument beside it."""

    tracks = True
    sweeps = 0

    def begin(self):
        self.sweeps += 1

    def take(self):
        return [Sample(0.0, (self.twin.measure_um_pp(self.clock.now()),))]


def tracked_run(laboratory, a_plan, plate, every_s):
    path = a_plan.journal_path(laboratory.folder)
    with Journal.create(path, plate.clock) as journal, plate:
        person = SimulatedParticipant(
            respondent_of(a_plan), feel=plate.vibration_level, clock=plate.clock
        )
        run_plan(
            a_plan,
            Setup(plate=plate, participant=person, journal=journal, clock=plate.clock,
                  operator=UnattendedOperator(),
                  tracking=ResonanceTracking(plate, plate, every_s)),
            spec="mock",
        )  # fmt: skip
    return read_plan(path)[1]


@pytest.mark.parametrize("every_s, sweeps", [(1e9, 1), (0.1, 3), (9.0, 2)])
def test_the_resonance_is_looked_for_between_trials_when_it_is_time(
    laboratory, plan, every_s, sweeps
):
    twin = Twin(resonator=Resonator(resonance_hz=30_550.0), noise_um=0.0)
    plate = Generator(clock=VirtualClock(), plate=Plate(calibration=calibration()), twin=twin)
    text = PLAIN.replace("[0.0, 2.3]", "[0.5, 1.2, 2.3]")
    records = tracked_run(laboratory, plan(text, seed=3), plate, every_s)
    found = [r.data for r in records if r.kind == "tracking"]
    assert len(found) == sweeps
    assert plate.sweeps == 3 * sweeps
    for each in found:
        assert each["refused"] == ""
        assert each["frequency_hz"] == pytest.approx(30_550, abs=5)  # it warms up
    # Each sweep stands before its trial's surface, and the rows are whole.
    assert found[0]["trial"] == 1
    assert gather(records).trials["magnitudeestimation"][-1].trial.number == 3


def test_a_fault_in_the_sweep_is_recovered_from_and_the_trial_begins_anew(laboratory, plan):
    plate = Generator(clock=VirtualClock(), plate=Plate(calibration=calibration()))
    plate.inject("lost", phase="present", n=2)
    records = tracked_run(laboratory, plan(PLAIN, seed=3), plate, 1e9)
    kinds = [r.kind for r in records if r.kind in ("fault", "tracking")]
    assert kinds == ["fault", "tracking"]
    assert len(gather(records).trials["magnitudeestimation"]) == 2
