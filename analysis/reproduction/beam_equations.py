"""Compare both sides of the equations of the bent section, (16) to (42), at the paper's numbers.

To record the computed values in ``beam_equations.json``, run ``python -m
slipscale.analysis.reproduction.beam_equations``. Do this only after an intended change to a model,
and explain in the commit message why the numbers changed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING

from slipscale.analysis.reproduction.comparison import Outcome, record
from slipscale.analysis.reproduction.equation import Check, apart, items

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from slipscale.hardware.plate.bending import Bending
    from slipscale.stimuli.quantities import Array, Number

#: The section of Section III-C, mm and V.
HALF_WAVE_MM, VOLTAGE_V = 83 / 8, 15.0
#: Width b of the plate.
WIDTH_M = 49e-3


@cache
def _bent() -> Bending:
    from slipscale.hardware.plate.beam import BeamSection
    from slipscale.hardware.plate.bending import Bending

    return Bending(section=BeamSection.printed(), half_wave_mm=HALF_WAVE_MM, voltage_v=VOLTAGE_V)


def _through(ceramic: Callable[[Array], Number], resonator: Callable[[Array], Number]) -> float:
    """Integrate over both layers by Simpson's rule, which is exact for cubics; z in mm, dz in m."""
    import numpy as np
    from scipy.integrate import simpson

    section = _bent().section
    step = section.ceramic_thickness_mm
    top = step + section.resonator_thickness_mm
    return sum(
        float(simpson(value(z := np.linspace(low, high, 201)), x=z * 1e-3))
        for value, low, high in ((ceramic, 0.0, step), (resonator, step, top))
    )


def _moduli() -> tuple[float, float]:
    section = _bent().section
    return section.ceramic.modulus_pa, section.resonator_modulus_pa


def _nothing(z: Array) -> Array:
    return 0 * z


def _curvature_of_deflection() -> float:
    """Return d²w/dx² of (27) by differences, in 1/m."""
    bent, step = _bent(), 0.1
    left, middle, right = (float(bent.deflection_um(x)) for x in (3 - step, 3.0, 3 + step))
    return (left - 2 * middle + right) * 1e-6 / (step * 1e-3) ** 2


def eq16() -> float:
    """Compare the slope of u along x with the strain of (18)."""
    import numpy as np

    bent, z = _bent(), np.linspace(0, 3, 13)
    slope = bent.axial_displacement_um(z, _curvature_of_deflection() * 1.0)
    return apart(slope * 1e-6, bent.strain(z))


def eq17() -> float:
    """Compare 1/ρ of (17) as printed with the curvature of the deflection that obeys (18)."""
    return apart(_bent().curvature_per_m, _curvature_of_deflection())


def eq18() -> float:
    """Compare both sides of (18), for the curvature of the deflection."""
    import numpy as np

    bent, z = _bent(), np.linspace(0, 3, 13)
    return apart((bent.neutral_mm - z) * 1e-3 * _curvature_of_deflection(), bent.strain(z))


def eq19() -> float:
    """Compare E_i S with the stress of a bar of the isotropic solid with free sides."""
    import numpy as np

    from slipscale.hardware.plate.materials import COPPER_BERYLLIUM

    bent, z = _bent(), np.linspace(1, 3, 9)
    young = 1 / np.linalg.inv(COPPER_BERYLLIUM.stiffness_pa)[0, 0]
    return apart(bent.resonator_stress_pa(z), young * bent.strain(z))


def eq20() -> float:
    """Compare (20) without stress along z with the constants of a thin layer."""
    import numpy as np

    from slipscale.hardware.plate.materials import P1_91

    c, e = P1_91.stiffness, P1_91.coupling
    plane = np.zeros(6)
    plane[0] = 1e-6
    plane[2] = -c[0, 2] / c[2, 2] * plane[0]
    field = np.array([0.0, 0.0, 1.0])
    stretched = float((c @ plane)[0]) / 1e-6
    driven = float((e.T @ field)[0] - c[0, 2] / c[2, 2] * (e.T @ field)[2])
    ours = (P1_91.plane_strain_pa, P1_91.reduced_e31_c_m2)
    return max(apart(stretched, ours[0]), apart(driven, ours[1]))


def eq21() -> float:
    """Compare e = d31 c11p below (21) with the e31 of Table II."""
    ceramic = _bent().section.ceramic
    return apart(ceramic.d31_m_v * ceramic.modulus_pa, -4.9)


def eq22() -> float:
    """Compare the moment of the ceramic's stress with minus that of the resonator's."""
    bent = _bent()
    arm = bent.neutral_mm

    def ceramic(z: Array) -> Number:
        return (z - arm) * bent.ceramic_stress_pa(z)

    def resonator(z: Array) -> Number:
        return (z - arm) * bent.resonator_stress_pa(z)

    return apart(_through(ceramic, _nothing), -_through(_nothing, resonator))


def eq23() -> float:
    """Compare both sides of (23) by quadrature."""
    bent = _bent()
    return apart(_contraction(), _resistance() * bent.curvature_per_m)


def _contraction() -> float:
    bent = _bent()
    stress = bent.section.ceramic.d31_m_v * _moduli()[0] * bent.field_v_m
    return _through(lambda z: (z - bent.neutral_mm) * 1e-3 * stress, _nothing)


def _resistance() -> float:
    """Return ∫ E (z - z0)² dz, the flexural rigidity per unit width."""
    z0, (ceramic, resonator) = _bent().neutral_mm, _moduli()
    return _through(
        lambda z: ceramic * (z - z0) ** 2 * 1e-6, lambda z: resonator * (z - z0) ** 2 * 1e-6
    )


def eq24() -> float:
    """Compare 1/ρ and d²w/dx² of (24) as printed with the integrals in (23) and with (18)."""
    right = _contraction() / _resistance()
    return max(apart(_bent().curvature_per_m, one) for one in (right, -right))


def eq25() -> float:
    """Compare 1/a of (25) with the integrals in (23)."""
    bent = _bent()
    hp = bent.section.ceramic_thickness_mm * 1e-3
    strain = bent.section.ceramic.d31_m_v * bent.field_v_m
    return apart(bent.section.inverse_a, _contraction() / _resistance() * 2 * hp / (3 * strain))


def _solved_um(x_mm: Array) -> Array:
    """Return w from the moments in (23) with the sign of (18), by differences between supports."""
    import numpy as np

    inner = len(x_mm) - 2
    differences = np.diag(np.full(inner, -2.0))
    differences += np.diag(np.ones(inner - 1), 1) + np.diag(np.ones(inner - 1), -1)
    step_m = (x_mm[1] - x_mm[0]) * 1e-3
    bent = np.full(inner, -_contraction() / _resistance() * step_m**2)
    return np.array([0.0, *np.linalg.solve(differences, bent), 0.0]) * 1e6


def eq27() -> float:
    """Compare (27) as printed with the deflection that obeys (18)."""
    import numpy as np

    bent, x = _bent(), np.linspace(0, HALF_WAVE_MM, 21)
    printed = bent.curvature_per_m / 2 * (x**2 - HALF_WAVE_MM * x)
    return apart(printed, _solved_um(x))


def _middle_um() -> float:
    """Return the deflection at mid-span that obeys (18)."""
    import numpy as np

    return float(_solved_um(np.linspace(0, HALF_WAVE_MM, 21))[10])


def eq28() -> float:
    """Compare (28) as printed with the deflection at mid-span that obeys (18)."""
    return apart(-_bent().section.static_deflection_um(HALF_WAVE_MM, VOLTAGE_V), _middle_um())


def _energies() -> tuple[float, float]:
    """Return U_piezo/b and U_mono/b by quadrature of (30) and (33), in J/m."""
    bent, (ceramic, resonator) = _bent(), _moduli()
    factor = HALF_WAVE_MM * 1e-3 / 2
    piezo = _through(lambda z: ceramic * bent.strain(z) ** 2, _nothing)
    rest = _through(_nothing, lambda z: resonator * bent.strain(z) ** 2)
    return factor * piezo, factor * (piezo + rest)


def eq29() -> float:
    """Compare (29), from energies by quadrature, with (36)."""
    section, (piezo, mono) = _bent().section, _energies()
    return apart(section.ceramic.quality_factor * mono / piezo, section.quality_factor)


def eq30() -> float:
    """Compare the last line of (31) with (30) by quadrature."""
    return apart(_bent().ceramic_energy_j_m, _energies()[0])


def eq31() -> float:
    """Compare the third line of (31) as printed, with z0²/h_p², with (30) by quadrature."""
    bent = _bent()
    f0, hp = bent.section.neutral_ratio, bent.section.ceramic_thickness_mm * 1e-3
    printed = 2 * HALF_WAVE_MM * 1e-3 * _moduli()[0] * hp**3 * bent.curvature_per_m**2 / 12
    return apart(printed * (1 - 3 * f0 + f0**2), _energies()[0])


def eq33() -> float:
    """Compare the last line of (35) with (33) by quadrature."""
    return apart(_bent().energy_j_m, _energies()[1])


def eq34() -> float:
    """Compare both sides of (34) by quadrature."""
    bent = _bent()
    return apart(bent.work_j_m, _resistance() * bent.curvature_per_m**2 * HALF_WAVE_MM / 2e3)


def eq35() -> float:
    """Compare the second line of (35) as printed, without E_z, with (33) by quadrature."""
    bent = _bent()
    f0, hp = bent.section.neutral_ratio, bent.section.ceramic_thickness_mm * 1e-3
    ceramic = bent.section.ceramic
    printed = 2 * HALF_WAVE_MM * 1e-3 * ceramic.d31_m_v * ceramic.modulus_pa * hp**2 / 8
    return apart(printed * bent.curvature_per_m * (1 - 2 * f0), _energies()[1])


def eq37() -> float:
    """Compare (37) as printed with the deflection that obeys (18) times Q by quadrature."""
    section, (piezo, mono) = _bent().section, _energies()
    printed = -section.dynamic_deflection_um_peak(HALF_WAVE_MM, VOLTAGE_V)
    return apart(_middle_um() * section.ceramic.quality_factor * mono / piezo, printed)


def eq38() -> float:
    """Compare (38) as printed with the frequency in Hz that balances both mean energies."""
    section = _bent().section
    q = math.pi / (HALF_WAVE_MM * 1e-3)
    ours = float(section.frequency_hz(HALF_WAVE_MM))
    return apart(q**2 * math.sqrt(_resistance() / section.mass_kg_m2), ours)


def eq39() -> float:
    """Compare (39) with the integral of the densities over the height."""
    section = _bent().section
    density = section.ceramic.density_kg_m3, section.resonator_density_kg_m3
    ours = _through(lambda z: density[0] + 0 * z, lambda z: density[1] + 0 * z)
    return apart(section.mass_kg_m2, ours)


def eq40() -> float:
    """Compare (40) as printed, with b in m, with the integrals in (23), per width as (39)."""
    return apart(_bent().section.rigidity_n_m * WIDTH_M, _resistance())


def eq41() -> float:
    """Compare (41) as printed, ∫ S·T dz, with 0."""
    ceramic, resonator = _moduli()
    bent = _bent()
    return apart(
        _through(
            lambda z: ceramic * bent.strain(z) ** 2, lambda z: resonator * bent.strain(z) ** 2
        ),
        0.0,
    )


def eq42() -> float:
    """Compare (42) with the height about which the stiffness has no first moment."""
    ceramic, resonator = _moduli()
    first = _through(lambda z: ceramic * z, lambda z: resonator * z)
    whole = _through(lambda z: ceramic + 0 * z, lambda z: resonator + 0 * z)
    return apart(_bent().neutral_mm, first / whole)


_SIGN = (
    "must have the opposite sign, as (18) requires; the amount is that of the moments in (23), "
    "integrated twice by differences"
)
CHECKS: Mapping[int, Check] = {
    16: Check(difference=eq16, reason="its slope along x is the strain of (18)", definition=True),
    17: Check(
        difference=eq17,
        reason="has the sign of 1/ρ = d²w/dx², but (18) requires 1/ρ = -d²w/dx²; Slipscale uses "
        "(18)",
    ),
    18: Check(
        difference=eq18,
        reason="definition of the strain; the curvature of our deflection has its sign",
        definition=True,
    ),
    19: Check(
        difference=eq19,
        reason="law of the material: the stress of a bar with free sides, from the full stiffness "
        "matrix",
        definition=True,
    ),
    20: Check(
        difference=eq20,
        reason="law of the material: without stress along z, it gives the constants of a thin "
        "layer",
        definition=True,
    ),
    21: Check(
        difference=eq21,
        reason="e = d31 c11p from Table II is -16.8 C/m² and contradicts its e31 = -4.9; only "
        "d31 = -247e-12 m/V reproduces Fig. 8, and Appendix B's reduced e31 would be -18.8",
    ),
    22: Check(difference=eq22, reason="moments of both layers by quadrature cancel"),
    23: Check(difference=eq23, reason="both sides by quadrature"),
    24: Check(
        difference=eq24,
        reason="1/ρ is the ratio of the integrals in (23), but d²w/dx² must have the opposite "
        "sign, as (18) requires",
    ),
    25: Check(difference=eq25, reason="from the integrals in (23)"),
    27: Check(difference=eq27, reason=_SIGN),
    28: Check(difference=eq28, reason=_SIGN),
    29: Check(difference=eq29, reason="energies by quadrature give (36)", also=(36,)),
    30: Check(difference=eq30, reason="by quadrature, equal to the last line of (31)"),
    31: Check(
        difference=eq31, reason="the third line must contain 3 z0²/h_p², as the integral shows"
    ),
    33: Check(difference=eq33, reason="by quadrature, equal to the last line of (35)", also=(32,)),
    34: Check(difference=eq34, reason="both sides by quadrature"),
    35: Check(
        difference=eq35, reason="the second line lacks the factor E_z; the last line is right"
    ),
    37: Check(
        difference=eq37,
        reason="has the sign of (28) and must have the opposite one; the amount is (28) times the "
        "amplification from energies by quadrature",
    ),
    38: Check(
        difference=eq38, reason="f_n is an angular frequency, so that it must be divided by 2π"
    ),
    39: Check(difference=eq39, reason="integral of the densities over the height", definition=True),
    40: Check(
        difference=eq40,
        reason="the print has the width b (49 mm here) only in (40) and not in (39), so that (38) "
        "would be 4.5 times too low; per unit width, (40) is right by quadrature",
    ),
    41: Check(
        difference=eq41,
        reason="∫ S·T dz is an energy and not zero; ∫ T dz = 0 gives (42), and finite elements "
        "have the neutral line there",
    ),
    42: Check(
        difference=eq42,
        reason="height about which the stiffness has no first moment, by quadrature",
    ),
}
ITEMS: Mapping[str, Callable[[], Outcome]] = items(CHECKS)
FIGURES: Mapping[str, Callable[[], Figure]] = {}


if __name__ == "__main__":
    record(ITEMS, "beam_equations.json")
