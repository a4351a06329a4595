import dataclasses
import math

import numpy as np
import pytest

from slipscale.faults import UserError
from slipscale.hardware.plate.finite_elements import POTENTIAL_UNIT_V, assemble
from slipscale.hardware.plate.geometry import Density, Layout, mesh_lines
from slipscale.hardware.plate.materials import COPPER_BERYLLIUM, P1_91, VACUUM_PERMITTIVITY_F_M
from slipscale.hardware.plate.vibration import modes

SMALL = Layout(length_mm=23.0, width_mm=10.0, columns=2, rows=1, gap_mm=1.0)
ROUGH = Density(along_ceramic=2, across_ceramic=2)


def rigid_bodies(nodes):
    x, y, z = nodes
    o, one = np.zeros_like(x), np.ones_like(x)
    return [
        np.concatenate(motion)
        for motion in ((one, o, o), (o, one, o), (o, o, one), (o, -z, y), (z, o, -x), (-y, x, o))
    ]


def test_rigid_bodies_cost_no_energy_and_raise_no_charge():
    parts = assemble(SMALL, ROUGH, quarter=False)
    stiff, coupled = abs(parts.stiffness).max(), abs(parts.coupling).max()
    for motion in rigid_bodies(parts.nodes):
        size = np.abs(motion).max()
        assert np.abs(parts.stiffness @ motion).max() < 1e-11 * stiff * size
        assert np.abs(parts.coupling.T @ motion).max() < 1e-11 * coupled * size


def test_matrices_are_symmetric_and_a_uniform_potential_does_nothing():
    parts = assemble(SMALL, ROUGH)
    for matrix in (parts.stiffness, parts.mass, parts.capacitance):
        assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
    uniform = np.ones(parts.nodes.shape[1])
    assert np.abs(parts.coupling @ uniform).max() < 1e-11 * abs(parts.coupling).max()
    assert np.abs(parts.capacitance @ uniform).max() < 1e-11 * abs(parts.capacitance).max()


@pytest.mark.parametrize("quarter, share", [(True, 0.25), (False, 1.0)])
def test_mass_is_that_of_resonator_and_ceramics_without_the_gaps(quarter, share):
    parts = assemble(
        Layout.prototype(), Density(along_ceramic=1, across_ceramic=1), quarter=quarter
    )
    kilograms = 83 * 49 * 2 * 8250e-9 + 35 * 11 * 9 * 1 * 7410e-9
    assert parts.mass.sum() / 3 == pytest.approx(share * kilograms, rel=1e-12)


def test_uniform_strain_stores_the_energy_of_the_stiffness_matrix():
    # Patch test: u = S·x gives energy ½ S c S V in each layer.
    layout = Layout(length_mm=10.0, width_mm=6.0)
    parts = assemble(layout, ROUGH, quarter=False)
    strain = np.array([1e-3, -2e-3, 5e-4, 3e-4, -7e-4, 9e-4])  # xx, yy, zz, yz, xz, xy
    xx, yy, zz, yz, xz, xy = strain
    gradient = np.array([[xx, xy / 2, xz / 2], [xy / 2, yy, yz / 2], [xz / 2, yz / 2, zz]])
    motion = (gradient @ parts.nodes).ravel()
    volume = 10e-3 * 6e-3 * np.array([2e-3, 1e-3])
    expected = sum(
        0.5 * strain @ c @ strain * v
        for c, v in zip((COPPER_BERYLLIUM.stiffness_pa, P1_91.stiffness), volume, strict=True)
    )
    assert 0.5 * motion @ parts.stiffness @ motion == pytest.approx(expected, rel=1e-12)


def test_uniform_field_and_strain_give_the_constants_of_the_ceramic():
    layout = Layout(length_mm=10.0, width_mm=6.0)
    parts = assemble(layout, ROUGH, quarter=False)
    volume = 10e-3 * 6e-3 * 1e-3
    potential = parts.nodes[2] / POTENTIAL_UNIT_V  # E_z = -1 V/m
    expected = 1470 * VACUUM_PERMITTIVITY_F_M * volume
    assert potential @ parts.capacitance @ potential == pytest.approx(expected, rel=1e-12)
    for stretch, constant in ((0, -4.9), (1, -4.9), (2, 21.4)):
        motion = np.zeros_like(parts.nodes)
        motion[stretch] = parts.nodes[stretch]
        work = motion.ravel() @ parts.coupling @ potential
        assert work == pytest.approx(constant * volume, rel=1e-12)
    shear = np.zeros_like(parts.nodes)
    shear[1] = parts.nodes[2]  # S_yz = 1 with a field along y: e24, column 4 of Appendix B
    across = parts.nodes[1] / POTENTIAL_UNIT_V
    assert shear.ravel() @ parts.coupling @ across == pytest.approx(17.1 * volume, rel=1e-12)


def test_mesh_lines_hit_every_ceramic_s_edge_and_a_gap_is_one_brick():
    lines = mesh_lines(Layout.prototype(), 0, 5.5, half=False)
    assert lines.size == 7 * 2 + 6 + 1
    assert np.sum(np.isclose(np.diff(lines), 1e-3)) == 6
    assert lines[0] == pytest.approx(-41.5e-3)
    half = mesh_lines(Layout.prototype(), 0, 5.5, half=True)
    assert half[0] == 0
    assert half == pytest.approx(lines[lines > -1e-9])


@pytest.mark.parametrize("columns, signs", [(7, [-1, 1, -1, 1, -1, 1, -1]), (2, [-1, 1])])
def test_polarity_alternates_with_plus_in_or_right_of_the_middle(columns, signs):
    layout = Layout(length_mm=12.0 * columns - 1, width_mm=9.0, columns=columns, gap_mm=1.0)
    assert [each.polarity for each in layout.patches] == signs
    assert layout.mirrors == (1 if columns % 2 else -1, 1)


def test_prototype_has_the_paper_s_ceramics():
    layout = Layout.prototype()
    assert math.isclose(layout.ceramic_length_mm, 11.0)
    assert math.isclose(layout.ceramic_width_mm, 9.0)


@pytest.mark.parametrize(
    "change, said",
    [
        ({"length_mm": -1.0}, "length_mm is -1 mm"),
        ({"gap_mm": -0.5}, "gap_mm is -0.5"),
        ({"columns": 0}, "columns and rows must be 1"),
        ({"gap_mm": 30.0}, "leave no room on 23.0 x 10.0 mm"),
    ],
)
def test_impossible_layout_is_refused(change, said):
    with pytest.raises(UserError, match=said):
        dataclasses.replace(SMALL, **change)


def test_impossible_density_is_refused():
    with pytest.raises(UserError, match="at least 1"):
        Density(along_ceramic=0)


def test_a_bare_border_has_the_resonators_mass_and_bends_like_a_beam():
    layout = Layout(length_mm=62.0, width_mm=6.0, border_mm=(30.0, 2.0), ceramic_thickness_mm=0.01)
    found = modes(layout, 2_000.0, 8, density=Density(along_ceramic=1, across_ceramic=1))
    bar, length_m, height_m = layout.resonator, 62e-3, 2e-3
    mass_kg = found.parts.mass.sum() / 3 * 4
    assert mass_kg == pytest.approx(bar.density_kg_m3 * length_m * 6e-3 * height_m, rel=1e-4)
    # Euler and Bernoulli's free beam; shear lowers the frequency of this one by 0.3 %.
    stiffness = math.sqrt(bar.young_pa * height_m**2 / 12 / bar.density_kg_m3)
    expected_hz = (4.730041 / length_m) ** 2 / (2 * math.pi) * stiffness
    assert found.frequency_hz[1] == pytest.approx(expected_hz, rel=0.005)


def test_a_border_that_leaves_no_room_for_ceramics_is_refused():
    with pytest.raises(UserError, match=r"a border of 6\.0 x 0\.0 mm leave no room"):
        Layout(length_mm=12.0, width_mm=9.0, border_mm=(6.0, 0.0))
