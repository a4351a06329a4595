"""The beam's closed forms, put into the equations that they solve."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad
from scipy.optimize import brentq

from slipscale.faults import UserError
from slipscale.hardware.plate import bending
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.bending import Bending
from slipscale.hardware.plate.geometry import Layout
from slipscale.hardware.plate.paper_study import half_wave_modes

PAPER = BeamSection.printed()
BENT = Bending(section=PAPER, half_wave_mm=10.37, voltage_v=15.0)
x, z = sp.symbols("x z")  # mm


@pytest.fixture(autouse=True)
def _symbols(monkeypatch):
    """Let symbols through the checks of numbers."""
    between = bending.between
    monkeypatch.setattr(
        bending,
        "between",
        lambda name, value, *rest: (
            value if isinstance(value, sp.Basic) else between(name, value, *rest)
        ),
    )


def through(in_ceramic, in_resonator):
    """Integrate over the height, layer by layer; z is in mm, the result per m."""
    return sum(
        quad(value, low, high, epsrel=1e-12)[0] * 1e-3
        for value, low, high in ((in_ceramic, 0, 1), (in_resonator, 1, 3))
    )


def test_the_deflection_meets_the_supports_and_its_curvature():
    w = BENT.deflection_um(x) * 1e-6
    assert w.subs(x, 0) == 0
    assert float(w.subs(x, 10.37)) == pytest.approx(0, abs=1e-18)
    curvature = sp.diff(w, x, 2) * 1e6  # x in mm
    assert float(curvature) == pytest.approx(-BENT.curvature_per_m, rel=1e-12)
    middle = float(w.subs(x, 10.37 / 2)) * 1e6
    assert middle == pytest.approx(float(PAPER.static_deflection_um(10.37, 15.0)), rel=1e-12)
    assert middle > 0  # a ceramic that shortens under the resonator raises the middle


def test_strain_is_the_slope_of_the_displacement():
    slope = sp.diff(BENT.deflection_um(x) * 1e-3, x)
    displacement = BENT.axial_displacement_um(z, slope) * 1e-3
    difference = sp.expand(sp.diff(displacement, x) - BENT.strain(z))
    assert max(abs(float(c)) for c in sp.Poly(difference, z).coeffs()) < 1e-18


def test_stresses_have_no_moment_and_no_force_about_the_neutral_line():
    z0 = BENT.neutral_mm

    def arm(h):
        return (h - z0) * 1e-3

    scale = PAPER.rigidity_n_m * abs(BENT.curvature_per_m)
    moment = through(
        lambda h: arm(h) * BENT.ceramic_stress_pa(h), lambda h: arm(h) * BENT.resonator_stress_pa(h)
    )
    assert moment == pytest.approx(0, abs=1e-12 * scale)
    assert BENT.moment_n == pytest.approx(0, abs=1e-12 * scale)
    assert BENT.actuation_n == pytest.approx(BENT.elastic_moment_n, rel=1e-12)  # (23)
    stiff = through(lambda h: PAPER.ceramic.modulus_pa * arm(h) ** 2, lambda h: 123e9 * arm(h) ** 2)
    assert BENT.elastic_moment_n == pytest.approx(stiff * BENT.curvature_per_m, rel=1e-12)
    assert BENT.axial_force_n_m == pytest.approx(0, abs=1e-9 * abs(BENT.ceramic_stress_pa(0.0)))


def test_energies_are_integrals_of_strain_times_elastic_stress():
    half_wave = 10.37e-3
    ceramic = through(lambda h: PAPER.ceramic.modulus_pa * BENT.strain(h) ** 2, lambda _: 0.0)
    resonator = through(lambda _: 0.0, lambda h: BENT.resonator_stress_pa(h) * BENT.strain(h))
    assert BENT.ceramic_energy_j_m == pytest.approx(half_wave / 2 * ceramic, rel=1e-12)
    assert BENT.energy_j_m == pytest.approx(half_wave / 2 * (ceramic + resonator), rel=1e-12)
    assert BENT.work_j_m == pytest.approx(BENT.energy_j_m, rel=1e-12)  # (34)
    assert BENT.quality_factor == pytest.approx(PAPER.quality_factor, rel=1e-12)  # (36)


def test_without_voltage_nothing_bends_and_too_much_is_refused():
    rest = Bending(section=PAPER, half_wave_mm=10.37, voltage_v=0.0)
    assert rest.curvature_per_m == 0
    assert rest.ceramic_stress_pa(0.0) == 0
    with pytest.raises(UserError, match="voltage_v is 10000 V"):
        Bending(section=PAPER, half_wave_mm=10.37, voltage_v=1e4)
    with pytest.raises(UserError, match="half_wave_mm is 0 mm"):
        Bending(section=PAPER, half_wave_mm=0.0, voltage_v=1.0)


def test_the_neutral_line_is_where_the_finite_elements_do_not_move_along_x():
    """(41) and (42), for a long section, in which the mode is pure bending."""
    layout = Layout.half_wave(20.0)
    found = half_wave_modes(layout)
    top = found.parts.at(z=found.parts.thickness_m)
    bent = np.cos(np.pi * found.parts.nodes[0, top] / 20e-3)
    mode = found.shape[np.argmax(np.abs(found.shape[:, 2, top] @ bent))]
    end = np.isclose(found.parts.nodes[0], found.parts.nodes[0].max())
    fit = np.polynomial.Polynomial.fit(found.parts.nodes[2, end] * 1e3, mode[0, end], 3)
    wide = BeamSection.plane_strain()
    found_mm = brentq(fit, 1.0, 2.5)
    assert found_mm == pytest.approx(wide.neutral_ratio, abs=0.02)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: BENT.strain(3.5), "z_mm is 3.5 mm"),
        (lambda: BENT.ceramic_stress_pa(1.5), "ceramic: z_mm is 1.5 mm"),
        (lambda: BENT.resonator_stress_pa(0.5), "resonator: z_mm is 0.5 mm"),
        (lambda: BENT.deflection_um(-1), "x_mm is -1 mm"),
        (lambda: BENT.deflection_um(np.nan), "x_mm is nan mm"),
        (
            lambda: Bending(section=PAPER, half_wave_mm=[10, 12], voltage_v=15),
            r"half_wave_mm is \[10, 12\], expected a number of mm",
        ),
        (lambda: PAPER.half_wave_for_frequency_mm([1e4, 2e4]), "expected a number of Hz"),
        (lambda: PAPER.half_wave_for_amplitude_mm([1, 2], 15), "expected a number of µm peak"),
        (lambda: PAPER.half_wave_for_amplitude_mm(1, [5, 15]), "expected a number of V"),
        (lambda: PAPER.timoshenko_half_wave_mm([1e4, 3e4]), r"\[10000.0, 30000.0\], expected"),
    ],
)
def test_values_outside_the_section_are_refused(call, words):
    with pytest.raises(UserError, match=words):
        call()


def test_the_amplification_does_not_depend_on_the_voltage():
    still = Bending(section=PAPER, half_wave_mm=10.37, voltage_v=0)
    assert still.quality_factor == pytest.approx(PAPER.quality_factor, rel=1e-12)
