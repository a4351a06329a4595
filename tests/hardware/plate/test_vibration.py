import dataclasses
import math

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from slipscale.faults import UserError
from slipscale.hardware.plate import paper_study
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.finite_elements import assemble
from slipscale.hardware.plate.geometry import HALF_WAVE, QUICK, Density, Layout
from slipscale.hardware.plate.materials import P1_91, BeamCeramic, Isotropic, Piezoceramic
from slipscale.hardware.plate.paper_study import (
    half_wave_for_frequency_mm,
    half_wave_frequency_hz,
    harmonic,
    prototype_modes,
)
from slipscale.hardware.plate.vibration import modes, nearest_node, response_um, support

STEEL = Isotropic(name="steel", young_pa=210e9, poisson=0.3, density_kg_m3=7850.0)
PASSIVE = Piezoceramic(  # steel in the place of the ceramic: one material, no coupling
    name="passive",
    density_kg_m3=7850.0,
    stiffness_pa=tuple(map(tuple, STEEL.stiffness_pa.tolist())),
    coupling_c_m2=((0.0,) * 6,) * 3,
    relative_permittivity=(1.0, 1.0, 1.0),
    quality_factor=60.0,
)
SMALL = Layout(length_mm=35.0, width_mm=10.0, columns=3, rows=1, gap_mm=1.0)
ROUGH = Density(along_ceramic=2, across_ceramic=2)


def steel_strip(length_mm, width_mm=8.0):
    return Layout(
        length_mm=length_mm, width_mm=width_mm, ends="supported", ceramic=PASSIVE, resonator=STEEL
    )


def mindlin_strip_hz(length_mm):
    """Return the exact frequency of an infinitely wide Mindlin plate, κ = 5/6 (3 mm of steel)."""
    one = BeamSection.plane_strain(PASSIVE, STEEL)
    return float(one.timoshenko_frequency_hz(length_mm))


def nodal_lines_mm(found, mode):
    """Return x in mm of the nodes on the touch surface's mid line (y = 0)."""
    parts = found.parts
    line = np.flatnonzero(parts.at(y=0.0, z=parts.thickness_m))
    line = line[np.argsort(parts.nodes[0, line])]
    x, w = parts.nodes[0, line] / 1e-3, found.shape[mode, 2, line]
    change = np.flatnonzero(w[:-1] * w[1:] < 0)
    at = x[change] - w[change] * (x[change + 1] - x[change]) / (w[change + 1] - w[change])
    if not parts.quarter:
        return np.asarray(at)
    middle = [0.0] if parts.mirrors[0] == -1 else []
    return np.concatenate([-at[::-1], middle, at])


def test_wide_supported_plate_has_the_analytic_frequency():
    # Free edges along the width matter less the wider the plate: 2 % at 12 half waves.
    layout = steel_strip(10.0, 120.0)
    found = half_wave_frequency_hz(layout, Density(along_ceramic=4, across_ceramic=12))
    assert found == pytest.approx(mindlin_strip_hz(10.0), rel=0.02)


def test_narrow_beam_has_the_euler_bernoulli_frequency_for_long_waves():
    # A beam of width 2 mm is in plane stress: Young's modulus itself.
    length, height = 120e-3, 3e-3
    euler = math.pi / (2 * length**2) * math.sqrt(210e9 * height**2 / 12 / 7850)
    layout = steel_strip(120.0, 2.0)
    found = modes(layout, euler, 3, density=Density(along_ceramic=8, across_ceramic=1))
    assert np.min(np.abs(found.frequency_hz / euler - 1)) < 4e-3


def test_frequency_converges_from_above_at_the_order_of_quadratic_elements():
    # Quadratic elements: the eigenvalue's error falls as h⁴ where the solution is smooth.
    frequencies = [
        modes(steel_strip(20.0, 4.0), 18_000.0, 1, density=d).frequency_hz[0]
        for d in (
            Density(along_ceramic=n, across_ceramic=1, ceramic_layers=1, resonator_layers=2)
            for n in (2, 4, 8)
        )
    ]
    steps = -np.diff(frequencies)
    assert np.all(steps > 0)
    assert 3 < math.log2(steps[0] / steps[1]) < 6


def test_half_waves_of_fig_9():
    # An independent prototype (27-node bricks): 51.69, 42.82, 35.69, 30.57, 22.89, 17.75, 11.52.
    expected = {9: 51.69, 10: 42.82, 11: 35.69, 12: 30.57, 14: 22.89, 16: 17.75, 20: 11.52}
    for half_wave, khz in expected.items():
        found = half_wave_frequency_hz(Layout.half_wave(float(half_wave)), HALF_WAVE) / 1e3
        assert found == pytest.approx(khz, rel=4e-3)


def test_half_wave_at_25_khz_lies_below_the_published_reading():
    # 13.6 mm is printed; the prototype gave 13.34 to 13.37.
    coarse = Density(along_ceramic=4, across_ceramic=6)
    assert half_wave_for_frequency_mm(25_000, density=coarse) == pytest.approx(13.38, abs=0.04)


def test_a_search_that_does_not_converge_ends_with_a_sentence(monkeypatch):
    """The excess exp(l / 0.3 mm) has no zero: each step is as long as the one before."""
    monkeypatch.setattr(
        paper_study,
        "half_wave_frequency_hz",
        lambda section, _: 25_000 * math.exp(math.exp((section.length_mm - 13) / 0.3)),
    )
    with pytest.raises(UserError, match="half-wavelength for 25000 Hz: not found in 20 iterations"):
        half_wave_for_frequency_mm(25_000)


def test_timoshenko_in_plane_strain_explains_the_numerical_curve():
    wide = BeamSection.plane_strain()
    for half_wave in (9.0, 12.0, 20.0):
        numerical = half_wave_frequency_hz(Layout.half_wave(half_wave))
        assert float(wide.timoshenko_frequency_hz(half_wave)) == pytest.approx(numerical, rel=0.016)


def test_driven_mode_of_the_prototype_is_the_published_8_0():
    found = prototype_modes(continuous=True, density=QUICK)
    # Printed: 35.6 kHz; this rough mesh lies 1 % above the finest (35.70).
    assert found.frequency_hz[found.driven] == pytest.approx(35.7e3, rel=0.015)
    assert nodal_lines_mm(found, found.driven).size == 8


def test_gaps_lower_the_driven_mode_and_open_electrodes_raise_it():
    shorted = prototype_modes(density=QUICK)
    floating = prototype_modes(density=QUICK, electrodes="open")
    low, high = (m.frequency_hz[m.driven] for m in (shorted, floating))
    assert low == pytest.approx(33.9e3, rel=0.016)  # prototype: 33.9-34.0
    assert high == pytest.approx(34.7e3, rel=0.016)  # prototype: 34.7; published: 34.77
    lines = nodal_lines_mm(shorted, shorted.driven)
    assert lines[4:] == pytest.approx([5.79, 17.15, 28.06, 37.49], abs=0.15)


def test_harmonic_amplitude_is_the_published_one_at_the_edge():
    found = prototype_modes(density=QUICK)
    edge, middle = harmonic(found), harmonic(found, where_mm=(0.0, 0.0))
    assert edge.peak_um_pp == pytest.approx(3.2, rel=0.03)  # printed: 3.2 µm
    assert edge.peak_um_pp / middle.peak_um_pp == pytest.approx(1.48, abs=0.05)


def test_amplitude_at_resonance_grows_with_voltage_and_q():
    found = prototype_modes(density=QUICK)
    one = harmonic(found, voltage_v=1.0, loss_factor=1 / 60).peak_um_pp
    assert harmonic(found, voltage_v=10.0, loss_factor=1 / 60).peak_um_pp == pytest.approx(10 * one)
    assert harmonic(found, voltage_v=1.0, loss_factor=1 / 120).peak_um_pp > 1.9 * one


def test_loss_in_the_ceramic_alone_is_its_share_of_the_strain_energy():
    found = prototype_modes(density=QUICK)
    loss = found.loss_from_ceramic()
    assert loss[found.driven] == pytest.approx(0.4 / 60, rel=0.1)
    assert np.all((loss >= 0) & (loss <= 1 / 60))
    assert harmonic(found, loss_factor=loss).peak_um_pp > 2 * harmonic(found).peak_um_pp


def strongest(found):
    """Return the frequency of the mode with the largest force from 20 to 60 kHz."""
    near = (found.frequency_hz > 20e3) & (found.frequency_hz < 60e3)
    return found.frequency_hz[np.argmax(np.where(near, np.abs(found.force), 0))]


def test_quarter_has_the_symmetric_modes_of_the_whole():
    quarter = modes(SMALL, 40_000.0, 6, density=ROUGH)
    whole = modes(SMALL, 40_000.0, 40, density=ROUGH, quarter=False)
    elastic = quarter.frequency_hz[quarter.frequency_hz > 100]
    for frequency in elastic:
        assert np.min(np.abs(whole.frequency_hz / frequency - 1)) < 1e-3
    assert strongest(quarter) == pytest.approx(strongest(whole), rel=1e-3)


def test_even_row_of_ceramics_drives_an_antisymmetric_mode():
    layout = dataclasses.replace(SMALL, length_mm=47.0, columns=4)
    quarter = modes(layout, 38_000.0, 8, density=ROUGH)
    whole = modes(layout, 38_000.0, 40, density=ROUGH, quarter=False)
    assert strongest(quarter) == pytest.approx(strongest(whole), rel=1e-3)
    lines = nodal_lines_mm(quarter, quarter.driven)
    assert lines.size == 5
    assert lines == pytest.approx(-lines[::-1])


def test_whole_free_plate_has_six_rigid_bodies():
    found = modes(SMALL, 2_000.0, 8, density=ROUGH, quarter=False)
    assert np.sum(found.frequency_hz < 50) == 6
    assert np.all(np.abs(found.force[found.frequency_hz < 50]) < 1e-6 * np.abs(found.force).max())


def test_modes_are_normalised_and_orthogonal():
    found = modes(SMALL, 40_000.0, 5, density=ROUGH)
    parts = found.parts
    flat = found.shape.reshape(5, -1)
    assert flat @ (parts.mass @ flat.T) == pytest.approx(np.eye(5), abs=1e-8)


def direct_response(layout, frequency_hz, voltage_v, loss):
    """Solve the complex system at one frequency: what superposition is checked against."""
    parts = assemble(layout, ROUGH)
    system = support(parts)
    lossy = 1 + 1j * loss
    omega = 2 * math.pi * frequency_hz
    matrix = sparse.bmat(
        [
            [lossy * system.stiffness - omega**2 * system.mass, lossy * system.coupling],
            [lossy * system.coupling.T, -lossy * system.capacitance],
        ],
        format="csc",
    )
    load = np.zeros(matrix.shape[0], dtype=complex)
    load[: system.free.size] = system.force * voltage_v
    solution = splu(matrix).solve(load)
    return parts, system, solution


def test_superposed_modes_give_the_direct_solution():
    found = modes(SMALL, 40_000.0, 60, density=ROUGH)
    frequency = float(found.frequency_hz[found.driven])
    parts, system, solution = direct_response(SMALL, frequency, 15.0, 1 / 60)
    motion = np.zeros(3 * parts.nodes.shape[1], dtype=complex)
    motion[system.free] = solution[: system.free.size]
    node = nearest_node(parts, (0.0, 5.0))
    direct = motion[2 * parts.nodes.shape[1] + node] * 1e6
    superposed = response_um(found, frequency, 15.0, 1 / 60, (0.0, 5.0))
    assert superposed == pytest.approx(direct, rel=0.01)


def test_static_deflection_is_that_of_the_composite_beam():
    # A narrow strip bends in plane stress: equation (28) with 1/s11 and d31 of Appendix B.
    length_mm, voltage_v = 60.0, 15.0
    layout = Layout(length_mm=length_mm, width_mm=1.5, ends="supported")
    parts = assemble(layout, Density(along_ceramic=12, across_ceramic=1))
    system = support(parts)
    matrix = sparse.bmat(
        [[system.stiffness, system.coupling], [system.coupling.T, -system.capacitance]],
        format="csc",
    )
    load = np.zeros(matrix.shape[0])
    load[: system.free.size] = system.force * voltage_v
    motion = np.zeros(3 * parts.nodes.shape[1])
    motion[system.free] = splu(matrix).solve(load)[: system.free.size]
    found = motion[2 * parts.nodes.shape[1] + nearest_node(parts, (0.0, 0.0))] * 1e6
    ceramic = BeamCeramic(
        name="plane stress",
        modulus_pa=1 / np.linalg.inv(P1_91.stiffness)[0, 0],
        d31_m_v=P1_91.d31_m_v,
        density_kg_m3=7410.0,
        quality_factor=60.0,
    )
    expected = float(BeamSection.printed(ceramic).static_deflection_um(length_mm, voltage_v))
    assert found == pytest.approx(expected, rel=0.02)


def test_power_put_in_is_power_lost():
    # Over a cycle: Im(F̄·u)/2 = -η/2 (u K u - coupling and field energy), the lossy parts.
    loss = 1 / 60
    found = modes(SMALL, 40_000.0, 6, density=ROUGH)
    frequency = float(found.frequency_hz[found.driven])
    _, system, solution = direct_response(SMALL, frequency, 15.0, loss)
    size = system.free.size
    motion, potential = solution[:size], solution[size:]
    put_in = -np.imag(np.vdot(system.force * 15.0, motion))
    lost = loss * np.real(
        np.vdot(motion, system.stiffness @ motion) + np.vdot(motion, system.coupling @ potential)
    )
    assert put_in == pytest.approx(lost, rel=1e-6)
    assert put_in > 0


@pytest.mark.parametrize(
    "call, said",
    [
        (lambda: modes(SMALL, -1.0, 3, density=ROUGH), "near_hz is -1 Hz"),
        (lambda: modes(SMALL, 1e4, 0, density=ROUGH), "count is 0, expected 1 to"),
        (lambda: modes(SMALL, 1e4, 10**6, density=ROUGH), "count is 1000000"),
        (lambda: half_wave_for_frequency_mm(0.0), "frequency_hz is 0"),
    ],
)
def test_bad_input_is_named(call, said):
    with pytest.raises(UserError, match=said):
        call()
