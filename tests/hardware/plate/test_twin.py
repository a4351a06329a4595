import numpy as np
import pytest

from slipscale.hardware.plate.dynamics import FingerLoad
from slipscale.hardware.plate.twin import OFF, Drive, Surroundings, Twin


def test_at_the_papers_voltage_and_resonance_the_twin_vibrates_with_the_papers_amplitude():
    twin = Twin(surroundings=Surroundings(warm_up_k=0, wander_k=0))
    twin.set_drive(Drive(frequency_hz=30_500, voltage_v=15), 0.0)
    assert twin.amplitude_um_pp(1.0) == pytest.approx(2.3)


def test_vibration_dies_away_when_the_drive_is_off():
    twin = Twin()
    twin.set_drive(Drive(target_um_pp=2.3), 0.0)
    twin.set_drive(OFF, 1.0)
    assert 0 < twin.amplitude_um_pp(1.001) < 1
    assert twin.amplitude_um_pp(1.1) < 1e-9


def test_a_held_amplitude_needs_more_voltage_under_a_finger_until_there_is_none_left():
    light, heavy = Twin(finger=FingerLoad(loss=1 / 3000)), Twin(finger=FingerLoad(loss=1 / 300))
    for twin in (light, heavy):
        twin.set_drive(Drive(target_um_pp=2.3), 0.0)
    assert light.amplitude_um_pp(1.0) == pytest.approx(2.3)
    assert 15 < light.voltage_v(1.0) < 16.5
    assert heavy.voltage_v(1.0) == 16.5
    assert heavy.amplitude_um_pp(1.0) == pytest.approx(2.3 * 16.5 / 18)


def test_readings_scatter_as_stated_and_belong_to_their_time():
    twin = Twin(seed=3, noise_um=0.005)
    twin.set_drive(Drive(target_um_pp=1.2), 0.0)
    times_s = 1 + 0.01 * np.arange(2000)
    readings = np.array([twin.measure_um_pp(t) for t in times_s])
    assert readings.mean() == pytest.approx(1.2, abs=5 * 0.005 / np.sqrt(2000))
    assert readings.std(ddof=1) == pytest.approx(0.005, rel=0.08)
    assert np.abs(np.corrcoef(readings[:-1], readings[1:])[0, 1]) < 0.1
    late = Twin(seed=3, noise_um=0.005)
    late.set_drive(Drive(target_um_pp=1.2), 1.0)
    assert late.measure_um_pp(times_s[777]) == readings[777]


def test_seeds_differ():
    one, two = Twin(seed=1), Twin(seed=2)
    assert one.temperature_c(300) != two.temperature_c(300)
    assert one.measure_um_pp(0.5) != two.measure_um_pp(0.5)


def test_temperature_warms_up_and_stays_within_its_bounds():
    twin = Twin(
        seed=5,
        surroundings=Surroundings(temperature_c=22, warm_up_k=2, warm_up_s=1_200, wander_k=0.5),
    )
    temperatures = np.array([twin.temperature_c(t) for t in np.linspace(0, 20_000, 500)])
    assert temperatures[-100:].mean() == pytest.approx(24, abs=0.3)
    assert np.all((temperatures > 21.4) & (temperatures < 24.6))


def test_volts_by_a_gain_of_ones_own_are_not_what_a_damped_plate_needs():
    twin = Twin(finger=FingerLoad(loss=1 / 300), surroundings=Surroundings(wander_k=0, warm_up_k=0))
    twin.set_drive(Drive(target_um_pp=1.2, volts_per_um=15 / 2.3), 0.0)
    assert twin.amplitude_um_pp(1.0) == pytest.approx(1.2 * 50 / 60)
    assert twin.voltage_v(1.0) == pytest.approx(1.2 * 15 / 2.3)
    twin.set_drive(Drive(target_um_pp=2.5, volts_per_um=18 / 2.3), 1.0)
    assert twin.voltage_v(2.0) == 16.5
