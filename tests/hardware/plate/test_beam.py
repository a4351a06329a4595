import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from slipscale.faults import UserError
from slipscale.hardware.plate.beam import BeamSection

PAPER = BeamSection.printed()
sections = st.builds(
    lambda beta, alpha: dataclasses.replace(
        PAPER,
        resonator_thickness_mm=beta,
        resonator_modulus_pa=alpha * PAPER.ceramic.modulus_pa,
    ),
    beta=st.floats(0.2, 5),
    alpha=st.floats(0.2, 5),
)


def modulus(section, z_mm):
    inside = z_mm < section.ceramic_thickness_mm
    return section.ceramic.modulus_pa if inside else section.resonator_modulus_pa


def through(section, integrand):
    """Integrate over the height in m, layer by layer."""
    step = section.ceramic_thickness_mm
    top = step + section.resonator_thickness_mm
    return sum(
        quad(lambda z: integrand(z * 1e-3, modulus(section, z)), low, high)[0] * 1e-3
        for low, high in ((0, step), (step, top))
    )


def test_published_numbers():
    assert round(PAPER.half_wave_for_amplitude_mm(1.5, 15), 1) == 8.2  # Fig. 8
    assert float(PAPER.dynamic_deflection_um_peak(10.37, 15)) == pytest.approx(2.40, abs=0.005)
    # 14.75 mm is printed (Fig. 9); Table II throughout gives this.
    assert PAPER.half_wave_for_frequency_mm(25_000) == pytest.approx(13.60, abs=0.005)
    assert PAPER.neutral_ratio == pytest.approx(1.675, abs=1e-3)


def test_the_published_14_75_mm_needs_two_sources_at_once():
    # Appendix B's c11 in (40), Table II's neutral line: 14.73 mm, close to the print.
    f0, hp = PAPER.neutral_ratio, 1e-3
    layer = 12.09e10 * ((1 - f0) ** 3 + f0**3) / 3
    rigidity = hp**3 * (layer + 123e9 * ((3 - f0) ** 3 - (1 - f0) ** 3) / 3)
    half_wave = math.sqrt(math.pi / 2 / 25_000 * math.sqrt(rigidity / PAPER.mass_kg_m2))
    assert half_wave * 1e3 == pytest.approx(14.73, abs=0.005)


@pytest.mark.parametrize(
    "half_wave, euler, timoshenko",
    [
        (9, 57.11, 51.85),
        (10, 46.26, 42.98),
        (11, 38.23, 36.17),
        (12, 32.13, 30.83),
        (14, 23.60, 23.13),
        (16, 18.07, 17.97),
        (20, 11.57, 11.70),
    ],
)
def test_half_wave_frequencies_of_an_independent_calculation(half_wave, euler, timoshenko):
    assert float(PAPER.frequency_hz(half_wave)) / 1e3 == pytest.approx(euler, abs=0.006)
    wide = BeamSection.plane_strain()
    found = float(wide.timoshenko_frequency_hz(half_wave)) / 1e3
    assert found == pytest.approx(timoshenko, abs=0.006)


@settings(deadline=None)
@given(section=sections)
def test_neutral_line_carries_no_net_force(section):
    z0 = section.neutral_ratio * section.ceramic_thickness_mm * 1e-3
    scale = through(section, lambda z, e: e * abs(z - z0))
    assert abs(through(section, lambda z, e: e * (z - z0))) < 1e-9 * scale


@settings(deadline=None)
@given(section=sections)
def test_rigidity_is_the_integral_over_the_height(section):
    z0 = section.neutral_ratio * section.ceramic_thickness_mm * 1e-3
    direct = through(section, lambda z, e: e * (z - z0) ** 2)
    assert section.rigidity_n_m == pytest.approx(direct, rel=1e-9)


@settings(deadline=None)
@given(section=sections, half_wave=st.floats(2, 30), voltage=st.floats(0.1, 16))
def test_static_deflection_balances_the_moments(section, half_wave, voltage):
    # Equation (22) solved directly: curvature = moment of the active stress over the rigidity.
    hp = section.ceramic_thickness_mm * 1e-3
    z0 = section.neutral_ratio * hp
    field = voltage / hp
    active = section.ceramic.d31_m_v * section.ceramic.modulus_pa * field
    moment = quad(lambda z: active * (z - z0), 0, hp)[0]
    curvature = -moment / section.rigidity_n_m  # S = (z0 - z) w'', equation (18)
    deflection = -curvature * (half_wave * 1e-3) ** 2 / 8
    found = float(section.static_deflection_um(half_wave, voltage))
    assert found == pytest.approx(deflection * 1e6, rel=1e-6, abs=1e-12)


@settings(deadline=None)
@given(section=sections)
def test_amplification_is_the_ratio_of_strain_energies(section):
    hp = section.ceramic_thickness_mm * 1e-3
    z0 = section.neutral_ratio * hp
    ceramic = quad(lambda z: section.ceramic.modulus_pa * (z - z0) ** 2, 0, hp)[0]
    expected = section.ceramic.quality_factor * section.rigidity_n_m / ceramic
    assert section.quality_factor == pytest.approx(expected, rel=1e-7)


@settings(deadline=None)
@given(section=sections, half_wave=st.floats(3, 30))
def test_inverses_are_inverse(section, half_wave):
    frequency = float(section.frequency_hz(half_wave))
    assert section.half_wave_for_frequency_mm(frequency) == pytest.approx(half_wave)
    slow = float(section.timoshenko_frequency_hz(half_wave))
    assert section.timoshenko_half_wave_mm(slow) == pytest.approx(half_wave)


@settings(deadline=None)
@given(section=sections)
def test_timoshenko_goes_over_into_euler_bernoulli_for_long_waves(section):
    thickness = section.ceramic_thickness_mm + section.resonator_thickness_mm
    ratios = [
        1 - float(section.timoshenko_frequency_hz(h) / section.frequency_hz(h))
        for h in (30 * thickness, 60 * thickness)
    ]
    assert 0 < ratios[1] < 0.01
    assert ratios[0] / ratios[1] == pytest.approx(4, rel=0.1)  # the gap closes as 1/length²


def test_one_material_has_its_neutral_line_in_the_middle_and_shear_factor_five_sixths():
    one = dataclasses.replace(
        PAPER,
        resonator_modulus_pa=PAPER.ceramic.modulus_pa,
        resonator_shear_pa=PAPER.ceramic_shear_pa,
    )
    assert one.neutral_ratio == pytest.approx(1.5)
    assert one.rigidity_n_m == pytest.approx(PAPER.ceramic.modulus_pa * 3e-3**3 / 12)
    assert one.shear_rigidity_n_m / (PAPER.ceramic_shear_pa * 3e-3) == pytest.approx(5 / 6)


def test_thin_resonator_leaves_the_ceramic_alone():
    thin = dataclasses.replace(PAPER, resonator_thickness_mm=1e-6)
    assert thin.neutral_ratio == pytest.approx(0.5, abs=1e-5)
    assert abs(float(thin.static_deflection_um(10.0, 15.0))) < 1e-4


def test_vectorised_over_half_waves():
    half_wave = np.linspace(8, 20, 5)
    assert PAPER.dynamic_deflection_um_peak(half_wave, 15).shape == (5,)
    assert PAPER.timoshenko_frequency_hz(half_wave).shape == (5,)


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: PAPER.frequency_hz(-1), "half_wave_mm is -1 mm"),
        (
            lambda: PAPER.static_deflection_um(10, 30),
            r"voltage_v is 30 V.*at most 16\.5",
        ),
        (lambda: PAPER.static_deflection_um(10, -1), "voltage_v is -1 V"),
        (lambda: PAPER.half_wave_for_amplitude_mm(0, 15), "amplitude_um_peak is 0"),
        (
            lambda: PAPER.half_wave_for_amplitude_mm(1, 0),
            "an amplitude of 1 µm peak is not reached at 0 V with any half-wavelength",
        ),
        (lambda: dataclasses.replace(PAPER, ceramic_thickness_mm=-1), "ceramic_thickness_mm is -1"),
    ],
)
def test_bad_input_is_named_with_the_range_allowed(call, said):
    with pytest.raises(UserError, match=said):
        call()
