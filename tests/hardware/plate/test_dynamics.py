import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from slipscale.faults import UserError
from slipscale.hardware.plate.dynamics import FingerLoad, Resonator, conditions

PLATE = conditions(Resonator())
RESONANCE_HZ = 30_500.0


def envelope_from_full_equation(*, quality_factor, frequency_hz, voltage_v, times_s):
    """Independent: integrate x'' + (w0/Q) x' + w0² x = (w0²/Q) g V cos(wt) and demodulate it."""
    w0, w = 2 * math.pi * RESONANCE_HZ, 2 * math.pi * frequency_hz
    gain = 2.3 / 15

    def motion(t, state):
        x, v = state
        force = w0**2 / quality_factor * gain * voltage_v * math.cos(w * t)
        return [v, force - w0 / quality_factor * v - w0**2 * x]

    solution = solve_ivp(
        motion, (0, times_s[-1]), [0, 0], rtol=1e-9, atol=1e-12, dense_output=True, max_step=2e-6
    )
    period_s = 1 / frequency_hz
    values = []
    for t in times_s:
        window = np.linspace(t - period_s, t, 400, endpoint=False)
        x = solution.sol(window)[0]
        values.append(abs(2 * np.mean(x * np.exp(-1j * w * window))))
    return np.array(values)


@pytest.mark.parametrize("detuning_hz", [0, 60, -200])
def test_envelope_agrees_with_the_full_second_order_equation_within_half_a_percent(detuning_hz):
    frequency_hz = RESONANCE_HZ + detuning_hz
    times_s = np.array([0.5e-3, 1e-3, 2e-3, 4e-3])
    full = envelope_from_full_equation(
        quality_factor=60, frequency_hz=frequency_hz, voltage_v=15, times_s=times_s
    )
    half_period_s = 0.5 / frequency_hz  # the demodulation's window is centred there
    ours = [
        abs(PLATE.step(0, t - half_period_s, voltage_v=15, frequency_hz=frequency_hz))
        for t in times_s
    ]
    np.testing.assert_allclose(ours, full, atol=0.005 * 2.3)


def test_steady_amplitude_is_the_published_one():
    """Section IV-A: 2.3 µm peak to peak at 15 V and 30.5 kHz."""
    assert abs(PLATE.response_um_pp_per_v(30_500)) * 15 == pytest.approx(2.3)


def test_half_power_bandwidth_is_resonance_over_q():
    half_width_hz = RESONANCE_HZ / 60 / 2
    side = abs(PLATE.response_um_pp_per_v(RESONANCE_HZ + half_width_hz))
    assert side == pytest.approx(abs(PLATE.response_um_pp_per_v(RESONANCE_HZ)) / math.sqrt(2))


def test_ring_down_loses_the_factor_e_in_one_time_constant():
    left = PLATE.step(2.3, PLATE.time_constant_s, voltage_v=0, frequency_hz=RESONANCE_HZ)
    assert abs(left) == pytest.approx(2.3 / math.e)
    assert PLATE.time_constant_s == pytest.approx(0.63e-3, rel=0.01)


@given(
    first=st.floats(0, 0.01),
    second=st.floats(0, 0.01),
    voltage_v=st.floats(0, 16),
    detuning_hz=st.floats(-500, 500),
)
def test_two_steps_are_one_long_step(first, second, voltage_v, detuning_hz):
    drive = {"voltage_v": voltage_v, "frequency_hz": RESONANCE_HZ + detuning_hz}
    twice = PLATE.step(PLATE.step(1 + 1j, first, **drive), second, **drive)
    assert twice == pytest.approx(PLATE.step(1 + 1j, first + second, **drive))


def test_a_finger_that_brings_q_from_60_to_50_needs_18_v_for_the_published_amplitude():
    touched = conditions(Resonator(), finger=FingerLoad(loss=1 / 300))
    assert touched.quality_factor == pytest.approx(50)
    assert 2.3 / abs(touched.response_um_pp_per_v(30_500)) == pytest.approx(18)


def test_warmth_lowers_the_resonance():
    warm = conditions(Resonator(), temperature_c=32)
    assert warm.resonance_hz == pytest.approx(30_500 - 53)


@pytest.mark.parametrize("value", [0, -1, math.nan, math.inf])
def test_an_impossible_resonator_is_refused_with_its_value(value):
    with pytest.raises(UserError, match=f"quality_factor is {value}"):
        Resonator(quality_factor=value)


def test_a_finger_cannot_feed_energy_in():
    with pytest.raises(UserError, match="loss"):
        FingerLoad(loss=-0.1)
