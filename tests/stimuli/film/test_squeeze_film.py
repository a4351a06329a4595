import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipscale.faults import UserError
from slipscale.stimuli.film.squeeze_film import (
    ClosedFormWarning,
    Finger,
    Gas,
    film_thickness_um,
    mean_overpressure,
    mean_pressure,
    relative_friction,
    squeeze_number,
)
from slipscale.stimuli.surface import VirtualSurface


def test_squeeze_number_of_the_prototype_is_the_printed_one():
    # Section IV-A: 15.9 at 30.5 kHz, h_r = 0.6 µm, 2.3 µm peak to peak.
    peak = VirtualSurface(level=2.3).amplitude_um_peak
    assert round(float(squeeze_number(30_500, peak, 0.6)), 1) == 15.9


def test_squeeze_number_exceeds_ten_above_the_paper_s_25_khz():
    assert squeeze_number(25_000, 3.0, 1.6) > 10  # Fig. 3
    assert squeeze_number(21_300, 3.0, 1.6) < 10


def test_friction_halves_at_the_paper_s_guideline():
    # Section II-D: about one half at h_r = 0.6 µm, h_vib = 1.5 µm, 0.5 N.
    assert float(relative_friction(1.5, 0.6, 40_000).relative_friction) == pytest.approx(0.5, 0.05)


def test_levitation_is_reported_and_not_clipped():
    friction = relative_friction([4.0, 5.0], 1.6, 40_000)  # Fig. 5: zero beyond 4 µm
    assert friction.levitates.tolist() == [False, True]
    assert friction.relative_friction[1] < -0.2


@pytest.mark.parametrize("length_mm", [0.3, 5.0, 10.0, 10.15, 10.33])
@pytest.mark.parametrize("ridge_um", [0.0, 3.0, 50.0])
def test_mean_overpressure_is_the_integral_of_the_pressure_profile(length_mm, ridge_um):
    finger = Finger(contact_length_mm=length_mm, ridge_amplitude_um=ridge_um)
    x = np.linspace(-length_mm / 2, length_mm / 2, 2_000_001)
    direct = np.trapezoid(mean_pressure(x, 1.15, 0.6, finger), x) / length_mm - 1
    assert float(mean_overpressure(1.15, 0.6, finger)) == pytest.approx(direct, rel=1e-7)


def test_pressure_is_the_time_mean_of_equation_11():
    # Normalised P over a period: edge·H̄/H, H̄ the film's time mean.
    finger = Finger()
    x, vibration, roughness = 0.17, 1.15, 0.6
    phase = np.linspace(0, 2 * math.pi, 4001)[:-1]
    thickness = film_thickness_um(x, phase, vibration, roughness)
    edge = film_thickness_um(5.0, phase, vibration, roughness)
    boundary = np.sqrt((edge**3).mean() / edge.mean()) / edge.mean()  # equation (10), p0 = 1
    direct = boundary * (thickness.mean() / thickness).mean()
    assert float(mean_pressure(x, vibration, roughness, finger)) == pytest.approx(direct, rel=1e-9)


def test_no_vibration_means_no_film_and_no_warning_at_any_frequency():
    friction = relative_friction(0.0, 0.6, 10.0)
    assert float(friction.relative_friction) == 1.0


def test_without_ridges_the_mean_pressure_is_that_of_two_plates():
    eps = 1.15 / 1.75
    flat = Finger(ridge_amplitude_um=0.0)
    expected = math.sqrt((1 + 1.5 * eps**2) / (1 - eps**2)) - 1
    assert float(mean_overpressure(1.15, 0.6, flat)) == pytest.approx(expected, rel=1e-12)


@settings(deadline=None)
@given(
    amplitude=st.floats(0.01, 5),
    roughness=st.floats(0.05, 3),
    factor=st.floats(1.05, 3),
)
def test_more_vibration_and_less_roughness_carry_more(amplitude, roughness, factor):
    finger = Finger(contact_length_mm=10.5)  # 30 whole ridges: no edge in the way
    base = mean_overpressure(amplitude, roughness, finger)
    assert mean_overpressure(amplitude * factor, roughness, finger) > base
    assert mean_overpressure(amplitude, roughness * factor, finger) < base


@settings(deadline=None)
@given(force=st.floats(0.1, 2.0), share=st.floats(0.1, 0.9))
def test_the_missing_friction_is_inverse_to_the_force(force, share):
    light = relative_friction(1.15, 0.6, 30_500, normal_force_n=share * force).relative_friction
    heavy = relative_friction(1.15, 0.6, 30_500, normal_force_n=force).relative_friction
    assert float((1 - light) * share) == pytest.approx(float(1 - heavy), rel=1e-12)


def test_arrays_broadcast():
    friction = relative_friction(
        np.linspace(0, 2, 5)[:, None], [0.4, 0.8], 40_000, normal_force_n=0.5
    )
    assert friction.relative_friction.shape == friction.squeeze_number.shape == (5, 2)


def test_below_the_closed_form_s_range_it_warns_with_the_number():
    with pytest.warns(ClosedFormWarning, match=r"squeeze number is 5\.21"):
        friction = relative_friction(1.15, 0.6, 10_000)
    assert not friction.closed_form_holds


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: squeeze_number(-1, 1, 0.6), "frequency_hz is -1 Hz"),
        (lambda: squeeze_number(1e4, -0.5, 0.6), "amplitude_um_peak is -0.5"),
        (lambda: squeeze_number(1e4, 0.0, 0.0), "roughness_um is 0"),
        (lambda: mean_overpressure([1.0, math.nan], 0.6), "amplitude_um_peak is nan"),
        (lambda: relative_friction(1, 0.6, 4e4, normal_force_n=0), "normal_force_n is 0"),
        (lambda: relative_friction("fast", 0.6, 4e4), "expected a number of µm peak"),
        (lambda: Finger(contact_length_mm=-1), "contact_length_mm is -1 mm"),
        (lambda: Finger(ridge_amplitude_um=-50), "ridge_amplitude_um is -50 µm"),
        (lambda: Gas(viscosity_pa_s=0), "viscosity_pa_s is 0"),
    ],
)
def test_impossible_input_is_named_with_its_value(call, said):
    with pytest.raises(UserError, match=said):
        call()
