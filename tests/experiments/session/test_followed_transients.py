"""Transients in a session: triggered by what is measured, played by the plate, in the data."""

import pytest

from slipscale.experiments.dataset.bids import build_dataset
from slipscale.experiments.running.pilot import run_simulated
from slipscale.experiments.running.rehearsal import check_supported
from slipscale.experiments.session.followed_textures import Following
from slipscale.experiments.study.run_plan import RunPlan
from slipscale.faults import UserError
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.contact.source import Sample
from slipscale.hardware.errors import Late
from slipscale.stimuli.surface import VirtualSurface
from slipscale.stimuli.transient import Transient

FRAME_S = 0.01
STUDY = """
name = "edges"
title = "Edges of friction"
participants = 1
seed = 3
[plate]
{sensor} = "simulated"
[[textures]]
name = "edge"
kind = "transient"
from_um_pp = 0.5
to_um_pp = 2.0
transition_s = 0.01
{trigger}
[[tasks]]
protocol = "magnitude_estimation"
practice = 0
repetitions = 1
"""


def transient(**changes):
    usual = {"from_level": 1.0, "to_level": 2.0, "transition_s": 0.01, "label": "T1"}
    return Transient(**usual | changes)


def felt(surface, finger, seconds):
    """Return the vibration every millisecond, and the times of changes, under a finger.

    ``finger`` maps a time to the first value of a sample.
    """
    clock = VirtualClock()
    plate = MockPlate(clock=clock)
    plate.connect()
    following = Following(plate, clock, [surface.sensor])
    plate.present(following.presented_as(surface))
    begun_s = clock.now()
    found, changes, frame = [], [], 0.0
    while (now_s := clock.now() - begun_s) < seconds:
        if now_s >= frame:
            sample = Sample(clock.now(), (finger(now_s), 0.0))
            changes += following.see(surface.sensor, [sample]) or []
            frame += FRAME_S
        found.append((now_s, plate.vibration_level()))
        clock.sleep(0.001)
    return found, [each - begun_s for each in changes]


def level_at(found, time_s):
    return min(found, key=lambda each: abs(each[0] - time_s))[1]


def test_an_edge_changes_the_plate_where_it_is_and_changes_back_behind_it():
    """At 100 mm/s, 20 mm and back: over the edge at 0.1 s and at 0.3 s."""

    def finger(time_s):
        return 100 * time_s if time_s < 0.2 else 40 - 100 * time_s

    found, changes = felt(transient(position_mm=10.0), finger, 0.4)
    assert changes == pytest.approx([0.1], abs=FRAME_S / 2)
    (begun_s,) = changes
    # Half a cosine of 10 ms, as seen through the plate's 0.6 ms.
    for part, level in ((0.0, 1.0), (0.5, 1.42), (1.5, 2.0)):
        assert level_at(found, begun_s + part * 0.01) == pytest.approx(level, abs=0.1)
    assert level_at(found, 0.28) == pytest.approx(2.0, abs=0.05)
    assert level_at(found, 0.34) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("command", ["check", "follow"])
def test_a_change_that_the_plate_repeats_because_the_computer_was_late_is_a_fault(command):
    clock = VirtualClock()
    plate = MockPlate(clock=clock)
    plate.connect()
    change = transient(position_mm=10.0).change(plate.modulator)
    act = plate.check if command == "check" else lambda: plate.follow(2.0)
    for late_s in (-0.001, 0.001):
        plate.present(VirtualSurface(level=1.0))
        plate.play(change)
        clock.sleep(change.period_s + late_s)
        if late_s < 0:
            act()
            assert plate.vibration_level() == pytest.approx(2.0, abs=0.01)
            continue
        with pytest.raises(Late, match="the plate repeated a change"):
            act()
        clock.sleep(0.1)
        assert plate.vibration_level() < 0.01
    plate.present(VirtualSurface(level=1.0))
    plate.check()


def test_a_change_with_a_duration_ends_by_itself_and_comes_once_each_time_over():
    def finger(time_s):
        return 20.0 if 0.1 < time_s < 0.5 or time_s > 0.7 else 0.0

    found, changes = felt(transient(position_mm=10.0, duration_s=0.05), finger, 1.0)
    assert len(changes) == 2
    for begun_s in changes:
        assert level_at(found, begun_s + 0.03) == pytest.approx(2.0, abs=0.05)
        assert level_at(found, begun_s + 0.08) == pytest.approx(1.0, abs=0.05)
        assert level_at(found, begun_s + 0.28) == pytest.approx(1.0, abs=0.05)


def test_a_force_that_hovers_around_the_trigger_triggers_once():
    def finger(time_s):
        return 4 * time_s if time_s < 0.13 else 0.52 + 0.03 * (round(time_s / FRAME_S) % 2 - 0.5)

    found, changes = felt(transient(force_n=0.5, to_level=0.2), finger, 1.0)
    assert changes == pytest.approx([0.125], abs=FRAME_S)
    assert level_at(found, 0.9) == pytest.approx(0.2, abs=0.05)


def test_a_delay_counts_from_the_contact_and_again_after_the_finger_was_lifted():
    def finger(time_s):
        return 0.0 if time_s < 0.1 or 0.6 < time_s < 0.8 else 0.5

    _, changes = felt(transient(delay_s=0.2, duration_s=0.1), finger, 1.2)
    assert changes == pytest.approx([0.3, 1.0], abs=2 * FRAME_S)


def plan(trigger, sensor):
    text = STUDY.format(trigger=trigger, sensor=sensor)
    return RunPlan(
        study_name="edges", study_text=text, participant="01", seed=3, language="en", mode="pilot"
    )  # fmt: skip


@pytest.mark.parametrize(
    "trigger, sensor, changes, flag",
    [
        ("position_mm = 5.0\nduration_s = 0.05", "position", 1, "n/a"),
        ("force_n = 15.0", "force", 0, "unchanged"),
    ],
)
def test_the_data_set_counts_changes_and_flags_trials_without_one(
    trigger, sensor, changes, flag, tmp_path
):
    run_simulated(tmp_path, plan(trigger, sensor), "mock")
    build_dataset(tmp_path)
    (table,) = tmp_path.glob("sub-01/beh/*_beh.tsv")
    header, row = (line.split("\t") for line in table.read_text("utf-8").splitlines())
    found = dict(zip(header, row, strict=True))
    assert float(found["changes"]) >= changes
    assert (found["changes"] == "0") == (changes == 0)
    assert found["flag"] == flag
    assert float(found["amplitude_readback_um_pp"]) == pytest.approx(0.5, abs=0.03)


def test_a_trigger_that_nothing_measures_is_refused_before_the_session():
    clock = VirtualClock()
    with MockPlate(clock=clock) as plate:
        with pytest.raises(UserError, match=r"it depends on the finger's force; name a sensor"):
            check_supported(plan("force_n = 0.5", "position"), plate)
        check_supported(plan("force_n = 0.5", "force"), plate)
