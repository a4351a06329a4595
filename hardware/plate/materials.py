"""Materials in Table II and Appendix B of Biet et al. (2007).

Vectors of six components follow the paper's Appendix B: xx, yy, zz, yz, xz, xy. Poling is along z.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from slipscale.faults import UserError
from slipscale.stimuli.quantities import Array, not_negative, positive

VACUUM_PERMITTIVITY_F_M = 8.8541878128e-12  # CODATA 2018
_POISSON_MIN, _POISSON_MAX = -1.0, 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Isotropic:
    """Isotropic elastic material.

    Parameters
    ----------
    name : str
        Name for messages and figures.
    young_pa : float
        Young's modulus, Pa.
    poisson : float
        Poisson's ratio, between -1 and 0.5, so that the stiffness matrix is positive definite.
    density_kg_m3 : float
        Density, kg/m³.
    source : str
        Source of the numbers.
    """

    name: str
    young_pa: float
    poisson: float
    density_kg_m3: float
    source: str = ""

    def __post_init__(self) -> None:
        positive(f"{self.name}: young_pa", self.young_pa, "Pa")
        positive(f"{self.name}: density_kg_m3", self.density_kg_m3, "kg/m³")
        if not _POISSON_MIN < self.poisson < _POISSON_MAX:
            raise UserError(
                "{name}: poisson is {poisson}, expected a number between -1 and 0.5; outside "
                "this range the stiffness matrix is not positive definite",
                name=self.name,
                poisson=self.poisson,
            )

    @property
    def shear_pa(self) -> float:
        """Shear modulus, Pa."""
        return self.young_pa / (2 * (1 + self.poisson))

    @property
    def plane_strain_pa(self) -> float:
        """Modulus of a wide strip that bends without lateral contraction, E/(1 - ν²), in Pa."""
        return self.young_pa / (1 - self.poisson**2)

    @property
    def stiffness_pa(self) -> Array:
        """Stiffness matrix, Pa, shape (6, 6)."""
        lame = self.young_pa * self.poisson / ((1 + self.poisson) * (1 - 2 * self.poisson))
        matrix = np.diag(np.array([2.0, 2, 2, 1, 1, 1]) * self.shear_pa)
        matrix[:3, :3] += lame
        return matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class Piezoceramic:
    """Piezoelectric ceramic that is poled along z, with full matrices.

    Parameters
    ----------
    name : str
        Name for messages and figures.
    density_kg_m3 : float
        Density, kg/m³.
    stiffness_pa : tuple of 6 tuples of 6
        Stiffness matrix c^E at constant field in Pa; symmetric and positive definite.
    coupling_c_m2 : tuple of 3 tuples of 6
        Piezoelectric matrix e in C/m²; zeros for a passive layer.
    relative_permittivity : tuple of 3
        Relative permittivity ε^S/ε0 along x, y, z at constant strain.
    quality_factor : float
        Mechanical quality factor Q_m.
    source : str
        Source of the numbers.
    """

    name: str
    density_kg_m3: float
    stiffness_pa: tuple[tuple[float, ...], ...] = field(repr=False)
    coupling_c_m2: tuple[tuple[float, ...], ...] = field(repr=False)
    relative_permittivity: tuple[float, float, float]
    quality_factor: float
    source: str = ""

    def __post_init__(self) -> None:
        positive(f"{self.name}: density_kg_m3", self.density_kg_m3, "kg/m³")
        positive(f"{self.name}: quality_factor", self.quality_factor, "(no unit)")
        positive(f"{self.name}: relative_permittivity", self.relative_permittivity, "(no unit)")
        if self.coupling.shape != (3, 6) or not np.isfinite(self.coupling).all():
            raise UserError(
                "{name}: coupling_c_m2 must be 3 rows of 6 finite numbers", name=self.name
            )
        stiffness = self.stiffness
        if stiffness.shape != (6, 6) or not np.isfinite(stiffness).all():
            raise UserError(
                "{name}: stiffness_pa must be 6 rows of 6 finite numbers", name=self.name
            )
        if not np.allclose(stiffness, stiffness.T):
            raise UserError("{name}: stiffness_pa is not symmetric", name=self.name)
        least = float(np.linalg.eigvalsh(stiffness)[0])
        if least <= 0:
            raise UserError(
                "{name}: stiffness_pa is not positive definite: its smallest eigenvalue is "
                "{least:.3g} Pa, expected above 0",
                name=self.name,
                least=least,
            )

    @property
    def stiffness(self) -> Array:
        """Stiffness c^E as an array, Pa, shape (6, 6)."""
        return np.array(self.stiffness_pa, dtype=float)

    @property
    def coupling(self) -> Array:
        """Piezoelectric constants e as an array, C/m², shape (3, 6)."""
        return np.array(self.coupling_c_m2, dtype=float)

    @property
    def plane_strain_pa(self) -> float:
        """Modulus along x of a wide, thin layer in Pa, c11 - c13²/c33 = s11/(s11² - s12²)."""
        c = self.stiffness
        return float(c[0, 0] - c[0, 2] ** 2 / c[2, 2])

    @property
    def reduced_e31_c_m2(self) -> float:
        """Stress along x per unit field in a thin layer, e31* = e31 - e33 c13/c33, in C/m²."""
        c, e = self.stiffness, self.coupling
        return float(e[2, 0] - e[2, 2] * c[0, 2] / c[2, 2])

    @property
    def d31_m_v(self) -> float:
        """Charge constant d31 in m/V, from d = e s, where s is the inverse of c^E."""
        return float(np.linalg.solve(self.stiffness, self.coupling[2])[0])

    @property
    def shear_xz_pa(self) -> float:
        """Shear modulus c55 for bending along x, Pa."""
        return float(self.stiffness[4, 4])


@dataclass(frozen=True, slots=True, kw_only=True)
class BeamCeramic:
    """Ceramic constants for the paper's beam model (Table II).

    Parameters
    ----------
    name : str
        Name for messages and figures.
    modulus_pa : float
        c11p of equation (21), Pa.
    d31_m_v : float
        Charge constant in m/V. The sign depends on the poling.
    density_kg_m3, quality_factor, source
        See `Piezoceramic`.
    """

    name: str
    modulus_pa: float
    d31_m_v: float
    density_kg_m3: float
    quality_factor: float
    source: str = ""

    def __post_init__(self) -> None:
        positive(f"{self.name}: modulus_pa", self.modulus_pa, "Pa")
        positive(f"{self.name}: density_kg_m3", self.density_kg_m3, "kg/m³")
        positive(f"{self.name}: quality_factor", self.quality_factor, "(no unit)")
        not_negative(f"{self.name}: |d31_m_v|", abs(self.d31_m_v), "m/V", maximum=1e-7)


COPPER_BERYLLIUM = Isotropic(
    name="copper beryllium",
    young_pa=123e9,
    poisson=0.31,
    density_kg_m3=8250.0,
    source="Biet et al. 2007, Table II and Appendix B",
)

P1_91_TABLE_II = BeamCeramic(
    name="P1-91 (Table II)",
    modulus_pa=6.79e10,
    d31_m_v=-247e-12,
    density_kg_m3=7410.0,
    quality_factor=60.0,
    source=(
        "Biet et al. 2007, Table II and Appendix B. The matrices in Appendix B give a modulus of "
        "7.34e10 Pa and a d31 of -184e-12 m/V; only the values in Table II reproduce Fig. 8."
    ),
)

P1_91 = Piezoceramic(
    name="P1-91 (Appendix B)",
    density_kg_m3=7410.0,
    stiffness_pa=(
        (12.09e10, 7.63e10, 7.31e10, 0, 0, 0),
        (7.63e10, 12.09e10, 7.31e10, 0, 0, 0),
        (7.31e10, 7.31e10, 11.26e10, 0, 0, 0),
        (0, 0, 0, 3.36e10, 0, 0),
        (0, 0, 0, 0, 3.36e10, 0),
        (0, 0, 0, 0, 0, 2.23e10),
    ),
    # In the paper, 17.1 is in column 5 of the second row; for poling along z, it must be in column
    # 4.
    coupling_c_m2=((0, 0, 0, 0, 17.1, 0), (0, 0, 0, 17.1, 0, 0), (-4.9, -4.9, 21.4, 0, 0, 0)),
    # Assumed, because the permittivity was not published. Between permittivities of 1000 and 2500,
    # resonance frequencies differ by 30 Hz.
    relative_permittivity=(1700.0, 1700.0, 1470.0),
    quality_factor=60.0,
    source="Biet et al. 2007, Appendix B; permittivity assumed, quality factor from Table II",
)
