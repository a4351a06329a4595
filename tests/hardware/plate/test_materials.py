import dataclasses

import numpy as np
import pytest

from slipscale.faults import UserError
from slipscale.hardware.plate.materials import COPPER_BERYLLIUM, P1_91, P1_91_TABLE_II


def test_isotropic_stiffness_inverts_to_young_and_poisson():
    compliance = np.linalg.inv(COPPER_BERYLLIUM.stiffness_pa)
    assert 1 / compliance[0, 0] == pytest.approx(123e9)
    assert -compliance[0, 1] / compliance[0, 0] == pytest.approx(0.31)
    assert 1 / compliance[3, 3] == pytest.approx(COPPER_BERYLLIUM.shear_pa)


def test_plane_strain_modulus_follows_from_the_compliance():
    # Table II's definition: s11/(s11² - s12²); Appendix B gives 7.34e10, printed is 6.79e10.
    s = np.linalg.inv(P1_91.stiffness)
    assert P1_91.plane_strain_pa == pytest.approx(s[0, 0] / (s[0, 0] ** 2 - s[0, 1] ** 2))
    assert P1_91.plane_strain_pa == pytest.approx(7.344e10, rel=1e-3)


def test_appendix_b_does_not_give_table_ii_s_piezoelectric_constants():
    assert P1_91.reduced_e31_c_m2 == pytest.approx(-18.8, abs=0.05)
    assert P1_91.d31_m_v == pytest.approx(-184e-12, abs=0.5e-12)
    assert P1_91_TABLE_II.d31_m_v == -247e-12


def test_table_ii_s_ratio_of_moduli_is_the_printed_one():
    assert round(COPPER_BERYLLIUM.young_pa / P1_91_TABLE_II.modulus_pa, 2) == 1.81


def test_ceramic_is_isotropic_across_its_poling():
    c, e = P1_91.stiffness, P1_91.coupling
    assert c[5, 5] == pytest.approx((c[0, 0] - c[0, 1]) / 2)
    assert e[0, 4] == e[1, 3] == 17.1


@pytest.mark.parametrize(
    "material, change, said",
    [
        (COPPER_BERYLLIUM, {"poisson": 0.5}, "poisson is 0.5, expected a number between -1"),
        (COPPER_BERYLLIUM, {"young_pa": -1.0}, "young_pa is -1 Pa"),
        (COPPER_BERYLLIUM, {"density_kg_m3": 0.0}, "density_kg_m3 is 0"),
        (P1_91, {"quality_factor": 0.0}, "quality_factor is 0"),
        (P1_91, {"relative_permittivity": (1.0, 1.0, -2.0)}, "relative_permittivity is -2"),
        (P1_91, {"coupling_c_m2": ((0.0,) * 6,)}, "3 rows of 6"),
        (P1_91, {"stiffness_pa": ((1.0,),)}, "6 rows of 6"),
        (P1_91_TABLE_II, {"modulus_pa": 0.0}, "modulus_pa is 0"),
        (P1_91_TABLE_II, {"d31_m_v": 1.0}, "d31_m_v. is 1 m/V, expected .* at most 1e-07"),
    ],
)
def test_non_physical_material_is_named(material, change, said):
    with pytest.raises(UserError, match=said):
        dataclasses.replace(material, **change)


def test_stiffness_that_is_not_positive_definite_is_refused_with_its_eigenvalue():
    rows = [list(row) for row in P1_91.stiffness_pa]
    rows[0][1] = rows[1][0] = 13e10  # c12 > c11
    with pytest.raises(UserError, match="not positive definite: its smallest eigenvalue is -9"):
        dataclasses.replace(P1_91, stiffness_pa=tuple(map(tuple, rows)))


def test_asymmetric_stiffness_is_refused():
    rows = [list(row) for row in P1_91.stiffness_pa]
    rows[0][1] = 7e10
    with pytest.raises(UserError, match="not symmetric"):
        dataclasses.replace(P1_91, stiffness_pa=tuple(map(tuple, rows)))
