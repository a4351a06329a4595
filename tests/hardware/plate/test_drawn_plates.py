"""Discs and patches at free places, against published frequencies and closed forms."""

import argparse
import dataclasses
import json
import math

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from slipscale.faults import UserError
from slipscale.hardware.cli import design
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.design import verdict
from slipscale.hardware.plate.finite_elements import assemble
from slipscale.hardware.plate.geometry import Density, Layout, Patch, Region, density_of
from slipscale.hardware.plate.materials import P1_91, BeamCeramic, Isotropic, Piezoceramic
from slipscale.hardware.plate.vibration import modes, nearest_node, support

STEEL = Isotropic(name="steel", young_pa=210e9, poisson=0.33, density_kg_m3=7850.0)
PASSIVE = Piezoceramic(
    name="passive",
    density_kg_m3=7850.0,
    stiffness_pa=tuple(map(tuple, STEEL.stiffness_pa.tolist())),
    coupling_c_m2=((0.0,) * 6,) * 3,
    relative_permittivity=(1.0, 1.0, 1.0),
    quality_factor=60.0,
)


def disc(diameter_mm, at_mm=(0.0, 0.0), polarity=1):
    region = Region(at_mm=at_mm, size_mm=(diameter_mm, diameter_mm), disc=True)
    return Patch(region=region, polarity=polarity)


def rectangle(size_mm, at_mm=(0.0, 0.0), polarity=1):
    return Patch(region=Region(at_mm=at_mm, size_mm=size_mm), polarity=polarity)


def round_plate(diameter_mm, **changes):
    layout = Layout(
        length_mm=diameter_mm, width_mm=diameter_mm, disc=True, drawn=(disc(diameter_mm),)
    )
    return dataclasses.replace(layout, **changes)


STEEL_DISC = round_plate(150.0, ceramic=PASSIVE, resonator=STEEL)  # 3 mm of one material


def free_disc_hz(number):
    """Return a frequency from Leissa's number λ² = ω a² √(ρh/D)."""
    height_m, radius_m = 3e-3, 75e-3
    stiffness = STEEL.young_pa * height_m**3 / 12 / (1 - STEEL.poisson**2)
    return number / radius_m**2 * math.sqrt(stiffness / (7850.0 * height_m)) / (2 * math.pi)


def disc_frequencies_hz(brick_mm):
    found = modes(STEEL_DISC, 3_000.0, 5, density=density_of(STEEL_DISC, brick_mm))
    return found.frequency_hz[found.frequency_hz > 50]


def test_a_free_disc_has_the_published_natural_frequencies():
    """Leissa, Vibration of Plates, NASA SP-160 (1969), free circular plate, Poisson's ratio 0.33.

    Two, no and four nodal diameters. The numbers are for thin plates; shear lowers the
    frequencies of this one by up to 1.5 %.
    """
    found = disc_frequencies_hz(10.0)
    for number in (5.253, 9.084, 21.6):
        nearest = found[np.argmin(np.abs(found - free_disc_hz(number)))]
        assert -0.015 < nearest / free_disc_hz(number) - 1 < 0.002


def test_the_frequency_of_a_cut_disc_converges_faster_than_the_second_order():
    coarse, medium, fine = (disc_frequencies_hz(75 / n)[1] for n in (3, 6, 12))
    assert 2 < math.log2((coarse - medium) / (medium - fine)) < 4


@pytest.mark.parametrize("quarter, share", [(True, 0.25), (False, 1.0)])
def test_cut_bricks_have_the_mass_of_a_disc_with_a_round_patch(quarter, share):
    layout = round_plate(40.0, drawn=(disc(22.0),))
    parts = assemble(layout, density_of(layout, 4.0), quarter=quarter)
    kilograms = math.pi * (20**2 * 2 * 8250e-9 + 11**2 * 1 * 7410e-9)
    assert parts.mass.sum() / 3 == pytest.approx(share * kilograms, rel=2e-4)


def static_um(layout, density, places_mm):
    """Return the static deflection at places for 15 V, with one node's height held."""
    parts = assemble(layout, density)
    system = support(parts)
    size, held = system.free.size, nearest_node(parts, (0.0, 0.0)) + 2 * parts.nodes.shape[1]
    keep = np.flatnonzero(system.free != held)
    coupling = system.coupling[keep]
    matrix = sparse.bmat(
        [[system.stiffness[keep][:, keep], coupling], [coupling.T, -system.capacitance]],
        format="csc",
    )
    load = np.zeros(matrix.shape[0])
    load[: size - 1] = system.force[keep] * 15.0
    motion = np.zeros(3 * parts.nodes.shape[1])
    motion[system.free[keep]] = splu(matrix).solve(load)[: size - 1]
    nodes = [nearest_node(parts, place) for place in places_mm]
    return motion[[2 * parts.nodes.shape[1] + node for node in nodes]] * 1e6


def beam(modulus_pa):
    return BeamSection.printed(
        BeamCeramic(
            name="ceramic",
            modulus_pa=modulus_pa,
            d31_m_v=P1_91.d31_m_v,
            density_kg_m3=7410.0,
            quality_factor=60.0,
        )
    )


def test_a_disc_covered_by_its_element_bends_to_the_sphere_of_two_layers():
    """Equal curvature in all directions: the beam's formula with E/(1 - ν) in both layers."""
    layout = round_plate(60.0)
    radius_mm = 25.0  # a mesh line
    (deflection,) = static_um(layout, density_of(layout, 5.0), [(0.0, radius_mm)])
    compliance = np.linalg.inv(P1_91.stiffness)
    ceramic = beam(1 / (compliance[0, 0] + compliance[0, 1]))
    biaxial_pa = layout.resonator.young_pa / (1 - layout.resonator.poisson)
    section = dataclasses.replace(ceramic, resonator_modulus_pa=biaxial_pa)
    expected = float(section.static_deflection_um(2 * radius_mm, 15.0))
    assert abs(deflection) == pytest.approx(abs(expected), rel=0.02)


def test_a_partial_patch_bends_its_length_and_leaves_the_rest_straight():
    """A narrow strip of 60 mm with 20 mm of ceramic: (28) gives the curvature below the patch."""
    layout = Layout(length_mm=60.0, width_mm=1.5, drawn=(rectangle((20.0, 1.5)),))
    places = [(10.0, 0.0), (20.0, 0.0), (30.0, 0.0)]
    near, far, end = static_um(layout, Density(along_ceramic=4, across_ceramic=1), places)
    compliance = np.linalg.inv(P1_91.stiffness)
    over_patch = float(beam(1 / compliance[0, 0]).static_deflection_um(20.0, 15.0))
    assert abs(near) == pytest.approx(abs(over_patch), rel=0.03)
    # The tangent at the patch's end: slope = 4 deflection / length of the patch.
    assert end - far == pytest.approx(far - near, rel=0.03)
    assert abs(end - near) == pytest.approx(4 * abs(over_patch), rel=0.05)


def test_opposite_patches_drive_the_odd_modes_in_a_quarter_as_in_the_whole():
    patches = (disc(12.0, (-12.0, 0.0), -1), disc(12.0, (12.0, 0.0), 1))
    layout = Layout(length_mm=50.0, width_mm=20.0, drawn=patches)
    assert layout.mirrors == (-1, 1)
    density = density_of(layout, 6.0)
    quarter = modes(layout, 20_000.0, 6, density=density)
    whole = modes(layout, 20_000.0, 24, density=density, quarter=False)
    assert quarter.parts.quarter
    assert not whole.parts.quarter
    best = quarter.frequency_hz[quarter.driven]
    nearest = np.argmin(np.abs(whole.frequency_hz - best))
    assert whole.frequency_hz[nearest] == pytest.approx(best, rel=1e-4)
    # The quarter has half the modal force of the whole, at a quarter of the modal mass.
    assert abs(whole.force[nearest]) == pytest.approx(2 * abs(quarter.force.max()), rel=0.01)


def test_a_plate_without_symmetry_is_solved_whole():
    layout = Layout(length_mm=50.0, width_mm=20.0, drawn=(rectangle((10.0, 8.0), (12.0, 3.0)),))
    assert layout.mirrors == (0, 0)
    assert not assemble(layout, density_of(layout, 8.0)).quarter


def test_rows_drawn_one_by_one_are_the_rows():
    rows = Layout(length_mm=35.0, width_mm=21.0, columns=3, rows=2, gap_mm=1.0)
    drawn = Layout(
        length_mm=35.0,
        width_mm=21.0,
        drawn=tuple(
            rectangle((11.0, 10.0), (12.0 * column, 5.5 * side), -1 if column else 1)
            for side in (1, -1)
            for column in (1, 0, -1)
        ),
    )
    first, other = (modes(each, 40e3, 4, density=Density(along_ceramic=2, across_ceramic=2))
                    for each in (rows, drawn))  # fmt: skip
    assert other.frequency_hz == pytest.approx(first.frequency_hz, rel=1e-9)
    assert np.abs(other.force) == pytest.approx(np.abs(first.force), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    "change, said",
    [
        (
            {"drawn": (disc(12.0, (20.0, 0.0)),)},
            "patch 1, centred at 20, 0 mm, must be on the plate",
        ),
        ({"drawn": (disc(12.0), disc(12.0, (5.0, 0.0)))}, "patches 1 and 2 overlap"),
        ({"drawn": (disc(12.0, polarity=2),)}, "polarity is 2, expected 1 or -1"),
        ({"ends": "supported"}, "the edge of a disc must be free, not supported"),
        ({"length_mm": 50.0}, "a disc of 50 x 40 mm"),
    ],
)
def test_a_plate_that_cannot_be_built_is_refused(change, said):
    with pytest.raises(UserError, match=said):
        round_plate(40.0, **change)


BRIEF = """
[requirements]
workspace_mm = [15, 15]
amplitude_um_peak = 0.3
[ceramic]
thickness_mm = 0.5
[resonator]
thickness_mm = 1
[[plate]]
name = "buzzer"
diameter_mm = 40
band_hz = [30000, 60000]
patch = [{ diameter_mm = 25 }]
"""


@pytest.fixture
def design_of(tmp_path, monkeypatch, capsys):
    """Run the command on a brief's text; its status and JSON."""
    # Two coarse meshes, which differ by 9 %.
    monkeypatch.setattr(verdict, "BRICKS_MM", (4.5, 3.0))
    monkeypatch.setattr(verdict, "CONVERGED", 0.1)
    add_arguments, run = design.COMMANDS["design"]
    parser = argparse.ArgumentParser()
    add_arguments(parser)

    def command(text):
        path = tmp_path / "brief.toml"
        path.write_text(text, encoding="utf-8")
        status = run(parser.parse_args([str(path), "--json"]))
        return status, json.loads(capsys.readouterr().out)

    return command


def test_a_drawn_plate_is_judged_at_the_finger(design_of):
    status, found = design_of(BRIEF)
    (plate,) = found["drawn_plates"]
    solution = plate["finite_elements"]
    assert status == 0
    assert plate["why_not"] == []
    assert plate["beyond_shipped_limits"][0].endswith("kHz (default limits: 25 to 40)")
    assert solution["resonance_hz"] == pytest.approx(46.1e3, rel=0.01)
    assert solution["amplitude_finger_um_peak"] == pytest.approx(1.26, rel=0.05)
    assert solution["amplitude_largest_um_peak"] >= solution["amplitude_finger_um_peak"]


@pytest.mark.parametrize(
    "was, now, said",
    [
        ("diameter_mm = 25", "diameter_mm = 60", "plate 'buzzer': .* reaches beyond the plate"),
        (
            BRIEF,
            BRIEF + BRIEF[BRIEF.index("[[plate]]") :],
            "plate: must have different names, but 'buzzer' occurs twice",
        ),
        ("diameter_mm = 25", "polarity = 1", "either size_mm .* or diameter_mm"),
        ("patch =", "finger_at_mm = [30, 0]\npatch =", "finger_at_mm is .*expected a position on"),
        ("[30000, 60000]", "[40000, 25000]", "must have the lower frequency first"),
        ("[30000, 60000]", "[40000, 40001]", "no mode is within band_hz"),
    ],
)
def test_a_drawn_plate_that_cannot_be_judged_is_named(was, now, said, design_of):
    with pytest.raises(UserError, match=said):
        design_of(BRIEF.replace(was, now))


def test_a_patch_that_does_not_fit_is_refused_before_anything_is_solved(design_of, monkeypatch):
    monkeypatch.setattr("slipscale.hardware.plate.design.sizing.design", lambda _: 1 / 0)
    with pytest.raises(UserError, match="reaches beyond the plate"):
        design_of(BRIEF.replace("diameter_mm = 25", "diameter_mm = 60"))
