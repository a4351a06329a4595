"""Bend a half-wave section with a constant voltage: equations (16) to (24), (27) and (29) to (35).

**All quantities are per unit width.** Heights z are in mm from the free face of the ceramic,
positions x in mm from the left support. Deflections are small, and glue has no thickness. One sign
convention replaces the two of the paper: z and w point up, S = (z0 - z) d²w/dx² as in (18), and so
d²w/dx² = -1/ρ instead of (17).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipscale.hardware.plate.beam import SAFE_VOLTAGE_V, BeamSection
from slipscale.stimuli.quantities import MICRO, MILLI, Array, Number, between, not_negative, single

_NODES = 6  # Gauss-Legendre nodes per layer; exact, because integrands are polynomials


@dataclass(frozen=True, slots=True, kw_only=True)
class Bending:
    """A half-wave section on two supports, bent by a constant voltage.

    Parameters
    ----------
    section : BeamSection
        Layers of the section.
    half_wave_mm : float
        Distance λ/2 between the supports, mm.
    voltage_v : float
        Voltage V_z between the electrodes, V.
    """

    section: BeamSection
    half_wave_mm: float
    voltage_v: float

    def __post_init__(self) -> None:
        single("bending: half_wave_mm", self.half_wave_mm, "mm")
        voltage = single("bending: voltage_v", self.voltage_v, "V", not_negative)
        not_negative("bending: voltage_v", voltage, "V", maximum=SAFE_VOLTAGE_V)

    @property
    def neutral_mm(self) -> float:
        """Height z0 of the neutral line, mm."""
        return self.section.neutral_ratio * self.section.ceramic_thickness_mm

    @property
    def field_v_m(self) -> float:
        """Electric field E_z in the ceramic, V/m."""
        return self.voltage_v / (self.section.ceramic_thickness_mm * MILLI)

    @property
    def curvature_per_m(self) -> float:
        """Curvature c = 1/ρ, equation (24), in 1/m."""
        hp = self.section.ceramic_thickness_mm * MILLI
        return 3 * self.section.ceramic.d31_m_v * self.field_v_m * self.section.inverse_a / (2 * hp)

    def deflection_um(self, x_mm: Number) -> Number:
        """Return the deflection w at a position, equation (27), with the sign of this module.

        Raises
        ------
        UserError
            If a position is not between the supports.
        """
        x = between("bending: x_mm", x_mm, "mm", 0, self.half_wave_mm) * MILLI
        span = self.half_wave_mm * MILLI
        return -self.curvature_per_m * (x**2 - span * x) / 2 / MICRO

    def axial_displacement_um(self, z_mm: Number, slope: Number) -> Number:
        """Return u of equation (16) for a slope dw/dx."""
        z = self._height("z_mm", z_mm)
        return (self.neutral_mm - z) * MILLI * between("slope", slope, "", -np.inf, np.inf) / MICRO

    def strain(self, z_mm: Number) -> Number:
        """Return the strain S_xx at a height, equation (18)."""
        z = self._height("z_mm", z_mm)
        return self._arm_m(z) * self.curvature_per_m

    def ceramic_stress_pa(self, z_mm: Number) -> Number:
        """Return the stress T_xx in the ceramic, equations (20) and (21)."""
        ceramic, top = self.section.ceramic, self.section.ceramic_thickness_mm
        z = between("ceramic: z_mm", z_mm, "mm", 0, top)
        return ceramic.modulus_pa * (self.strain(z) - ceramic.d31_m_v * self.field_v_m)

    def resonator_stress_pa(self, z_mm: Number) -> Number:
        """Return the stress T_i in the resonator, equations (19) and (21)."""
        z = self._height("resonator: z_mm", z_mm, self.section.ceramic_thickness_mm)
        return self.section.resonator_modulus_pa * self.strain(z)

    @property
    def moment_n(self) -> float:
        """Moment M/b of all stresses about the neutral line, equation (22), in N; it is zero."""
        return self._through(
            lambda z: self._arm_m(z) * self.ceramic_stress_pa(z),
            lambda z: self._arm_m(z) * self.resonator_stress_pa(z),
        )

    @property
    def actuation_n(self) -> float:
        """Moment of the ceramic's contraction, left side of equation (23), in N."""
        ceramic = self.section.ceramic
        stress = ceramic.d31_m_v * ceramic.modulus_pa * self.field_v_m
        return self._through(lambda z: self._arm_m(z) * stress, np.zeros_like)

    @property
    def elastic_moment_n(self) -> float:
        """Moment that resists bending, right side of equation (23), in N."""
        return self.section.rigidity_n_m * self.curvature_per_m

    @property
    def ceramic_energy_j_m(self) -> float:
        """Elastic energy U_piezo/b of the ceramic, equations (30) and (31), in J/m.

        The third line of (31) needs 3 z0²/h_p².
        """
        return self._energy * (1 - 3 * self._f0 + 3 * self._f0**2) * self.section.inverse_a**2

    @property
    def energy_j_m(self) -> float:
        """Elastic energy U_mono/b of the section, equations (32) to (35), in J/m.

        The second line of (35) lacks the factor E_z.
        """
        return self._energy * (1 - 2 * self._f0) * self.section.inverse_a

    @property
    def work_j_m(self) -> float:
        """Work of the ceramic's contraction, left side of equation (34) times λ/4, in J/m."""
        return self.half_wave_mm * MILLI / 2 * self.actuation_n * self.curvature_per_m

    @property
    def quality_factor(self) -> float:
        """Dynamic amplification Q from the energies, equation (29)."""
        # Both energies are proportional to the voltage squared, which cancels.
        f0 = self._f0
        ratio = (1 - 2 * f0) / ((1 - 3 * f0 + 3 * f0**2) * self.section.inverse_a)
        return self.section.ceramic.quality_factor * ratio

    @property
    def axial_force_n_m(self) -> float:
        """Force ∫ T dz without a field, in N/m; zero by equation (41), which prints ∫ S·T dz."""
        ceramic, resonator = self.section.ceramic.modulus_pa, self.section.resonator_modulus_pa
        return self._through(
            lambda z: ceramic * self.strain(z), lambda z: resonator * self.strain(z)
        )

    @property
    def _f0(self) -> float:
        return self.section.neutral_ratio

    @property
    def _energy(self) -> float:
        """Common factor of the last lines of (31) and (35), in J/m; λ is twice the half wave."""
        ceramic = self.section.ceramic
        volume = 2 * self.half_wave_mm * self.section.ceramic_thickness_mm * MILLI**2
        return 3 / 16 * volume * (ceramic.d31_m_v * self.field_v_m) ** 2 * ceramic.modulus_pa

    def _height(self, name: str, z_mm: Number, low_mm: float = 0.0) -> Number:
        top = self.section.ceramic_thickness_mm + self.section.resonator_thickness_mm
        return between(name, z_mm, "mm", low_mm, top)

    def _arm_m(self, z_mm: Number) -> Number:
        return (z_mm - self.neutral_mm) * MILLI

    def _through(
        self, in_ceramic: Callable[[Array], Number], in_resonator: Callable[[Array], Number]
    ) -> float:
        """Integrate over the height in m."""
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        faces = np.cumsum(
            [0.0, self.section.ceramic_thickness_mm, self.section.resonator_thickness_mm]
        )
        total = 0.0
        for value, low, high in zip((in_ceramic, in_resonator), faces[:-1], faces[1:], strict=True):
            z = low + (high - low) * (1 + nodes) / 2
            total += float(np.sum(weights * value(z))) * (high - low) / 2 * MILLI
        return total
