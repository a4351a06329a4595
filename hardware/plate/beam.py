"""Model a half-wave section as a composite beam: equations (16) to (42), and a Timoshenko beam.

**All quantities are per unit width.** The factor b in the published equation (40) is therefore
omitted; with it, (38) and (39) would give a frequency that is lower by a factor of sqrt(b). The
signs of (17) and (18) are made consistent (z up, w up, curvature d²w/dx²).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from slipscale.faults import UserError
from slipscale.hardware.limits import PlateLimits
from slipscale.hardware.plate.materials import (
    COPPER_BERYLLIUM,
    P1_91,
    P1_91_TABLE_II,
    BeamCeramic,
    Isotropic,
    Piezoceramic,
)
from slipscale.stimuli.quantities import MICRO, MILLI, Array, not_negative, positive, single

SAFE_VOLTAGE_V = PlateLimits().voltage_v  # limit of the driver, above the paper's 15 V


@dataclass(frozen=True, slots=True, kw_only=True)
class BeamSection:
    """Beam of a ceramic layer (0 < z < h_p) under a resonator (h_p < z < h_p + h_i).

    Parameters
    ----------
    ceramic : BeamCeramic
        Active layer.
    resonator_modulus_pa : float
        Modulus of the resonator along x in Pa: E_i in the paper, E/(1 - ν²) in plane strain.
    resonator_density_kg_m3 : float
        Density of the resonator, kg/m³.
    ceramic_shear_pa, resonator_shear_pa : float
        Shear moduli in the xz plane in Pa, used only for the Timoshenko beam.
    ceramic_thickness_mm, resonator_thickness_mm : float
        Thicknesses h_p and h_i, mm.
    """

    ceramic: BeamCeramic
    resonator_modulus_pa: float
    resonator_density_kg_m3: float
    ceramic_shear_pa: float
    resonator_shear_pa: float
    ceramic_thickness_mm: float = 1.0
    resonator_thickness_mm: float = 2.0

    def __post_init__(self) -> None:
        for name, unit in {
            "resonator_modulus_pa": "Pa",
            "resonator_density_kg_m3": "kg/m³",
            "ceramic_shear_pa": "Pa",
            "resonator_shear_pa": "Pa",
            "ceramic_thickness_mm": "mm",
            "resonator_thickness_mm": "mm",
        }.items():
            single(f"beam section: {name}", getattr(self, name), unit)

    @classmethod
    def printed(
        cls,
        ceramic: BeamCeramic = P1_91_TABLE_II,
        resonator: Isotropic = COPPER_BERYLLIUM,
        *,
        shear_pa: float = P1_91.shear_xz_pa,
        ceramic_thickness_mm: float = 1.0,
        resonator_thickness_mm: float = 2.0,
    ) -> Self:
        """Return the beam as modelled in the paper: Young's modulus, and constants in Table II."""
        return cls(
            ceramic=ceramic,
            resonator_modulus_pa=resonator.young_pa,
            resonator_density_kg_m3=resonator.density_kg_m3,
            ceramic_shear_pa=shear_pa,
            resonator_shear_pa=resonator.shear_pa,
            ceramic_thickness_mm=ceramic_thickness_mm,
            resonator_thickness_mm=resonator_thickness_mm,
        )

    @classmethod
    def plane_strain(
        cls,
        ceramic: Piezoceramic = P1_91,
        resonator: Isotropic = COPPER_BERYLLIUM,
        *,
        ceramic_thickness_mm: float = 1.0,
        resonator_thickness_mm: float = 2.0,
    ) -> Self:
        """Return the beam for a plate much wider than its half-wavelength (plane strain)."""
        return cls(
            ceramic=BeamCeramic(
                name=ceramic.name,
                modulus_pa=ceramic.plane_strain_pa,
                d31_m_v=ceramic.reduced_e31_c_m2 / ceramic.plane_strain_pa,
                density_kg_m3=ceramic.density_kg_m3,
                quality_factor=ceramic.quality_factor,
                source=ceramic.source,
            ),
            resonator_modulus_pa=resonator.plane_strain_pa,
            resonator_density_kg_m3=resonator.density_kg_m3,
            ceramic_shear_pa=ceramic.shear_xz_pa,
            resonator_shear_pa=resonator.shear_pa,
            ceramic_thickness_mm=ceramic_thickness_mm,
            resonator_thickness_mm=resonator_thickness_mm,
        )

    @property
    def alpha(self) -> float:
        """Ratio α of the moduli, equation (26)."""
        return self.resonator_modulus_pa / self.ceramic.modulus_pa

    @property
    def beta(self) -> float:
        """Ratio β of the thicknesses, equation (26)."""
        return self.resonator_thickness_mm / self.ceramic_thickness_mm

    @property
    def neutral_ratio(self) -> float:
        """Position of the neutral line, f0 = z0/h_p, from equation (42).

        The position follows from ∫ T dz = 0; the paper prints ∫ S·T dz.

        >>> round(BeamSection.printed().neutral_ratio, 4)
        1.6755
        """
        a, b = self.alpha, self.beta
        return (1 + a * b**2 + 2 * a * b) / (2 * (1 + a * b))

    @property
    def mass_kg_m2(self) -> float:
        """Mass M_b per unit length and unit width in kg/m², equation (39)."""
        return MILLI * (
            self.ceramic.density_kg_m3 * self.ceramic_thickness_mm
            + self.resonator_density_kg_m3 * self.resonator_thickness_mm
        )

    @property
    def rigidity_n_m(self) -> float:
        """Flexural rigidity G_b per unit width about the neutral line in N·m, equation (40)."""
        f0, b = self.neutral_ratio, self.beta
        hp = self.ceramic_thickness_mm * MILLI
        layer = self.ceramic.modulus_pa * _cube_span(0, 1, f0)
        return hp**3 * (layer + self.resonator_modulus_pa * _cube_span(1, 1 + b, f0))

    @property
    def rotary_inertia_kg(self) -> float:
        """Rotary inertia about the neutral line per unit length and unit width, in kg."""
        f0, b = self.neutral_ratio, self.beta
        hp = self.ceramic_thickness_mm * MILLI
        layer = self.ceramic.density_kg_m3 * _cube_span(0, 1, f0)
        return hp**3 * (layer + self.resonator_density_kg_m3 * _cube_span(1, 1 + b, f0))

    @property
    def inverse_a(self) -> float:
        """1/a in equation (25)."""
        f0, a, b = self.neutral_ratio, self.alpha, self.beta
        resonator = 3 * b + 3 * b**2 + b**3 - 6 * b * f0 - 3 * b**2 * f0 + 3 * b * f0**2
        return (1 - 2 * f0) / (1 - 3 * f0 + 3 * f0**2 + a * resonator)

    @property
    def quality_factor(self) -> float:
        """Dynamic amplification Q, equation (36), if only the ceramic loses energy.

        The energies are computed from (31) with 3 z0²/h_p² in the third line, and from (35) with
        E_z in the second line.
        """
        f0 = self.neutral_ratio
        share = (1 - 2 * f0) / (self.inverse_a * (1 - 3 * f0 + 3 * f0**2))
        return self.ceramic.quality_factor * share

    def static_deflection_um(self, half_wave_mm: npt.ArrayLike, voltage_v: npt.ArrayLike) -> Array:
        """Return the upward deflection in µm at mid-span for a constant voltage, equation (28).

        The sign is opposite to the published one. A ceramic that shortens under the resonator
        raises the middle of the span according to (18), S = (z0 - z) w'', but lowers it according
        to (17).

        Raises
        ------
        UserError
            If the half-wavelength is not positive, or if the voltage exceeds `SAFE_VOLTAGE_V`.
        """
        half_wave = positive("half_wave_mm", half_wave_mm, "mm") * MILLI
        voltage = not_negative("voltage_v", voltage_v, "V", maximum=SAFE_VOLTAGE_V)
        hp = self.ceramic_thickness_mm * MILLI
        bent = 3 * self.ceramic.d31_m_v * voltage * half_wave**2 * self.inverse_a / (16 * hp**2)
        return np.asarray(bent / MICRO)

    def dynamic_deflection_um_peak(
        self, half_wave_mm: npt.ArrayLike, voltage_v: npt.ArrayLike
    ) -> Array:
        """Return |w_dyn| at resonance in µm peak for a voltage in V peak, equation (37), Fig. 8."""
        return np.abs(self.static_deflection_um(half_wave_mm, voltage_v)) * self.quality_factor

    def half_wave_for_amplitude_mm(self, amplitude_um_peak: float, voltage_v: float) -> float:
        """Return the half-wavelength in mm at which the dynamic deflection has the given amplitude.

        >>> round(BeamSection.printed().half_wave_for_amplitude_mm(1.5, 15), 1)  # printed: 8.2
        8.2
        """
        wanted = single("amplitude_um_peak", amplitude_um_peak, "µm peak")
        single("voltage_v", voltage_v, "V", not_negative)
        at_one = float(self.dynamic_deflection_um_peak(1.0, voltage_v))
        if at_one == 0:
            raise UserError(
                "an amplitude of {wanted:g} µm peak is not reached at {voltage_v:g} V with any "
                "half-wavelength; expected a voltage and a charge constant d31 other than 0",
                wanted=wanted,
                voltage_v=voltage_v,
            )
        return float(np.sqrt(wanted / at_one))

    def frequency_hz(self, half_wave_mm: npt.ArrayLike) -> Array:
        """Return the resonance frequency in Hz of a simply supported half-wave section.

        Equation (38) is divided by 2π, because the published f_n is an angular frequency.
        """
        q = np.pi / (positive("half_wave_mm", half_wave_mm, "mm") * MILLI)
        return np.asarray(q**2 * np.sqrt(self.rigidity_n_m / self.mass_kg_m2) / (2 * np.pi))

    def half_wave_for_frequency_mm(self, frequency_hz: float) -> float:
        """Return the half-wavelength in mm for a resonance frequency (inverse of (38))."""
        f = single("frequency_hz", frequency_hz, "Hz")
        return float(np.sqrt(self.frequency_hz(1.0) / f))

    @property
    def shear_rigidity_n_m(self) -> float:
        """Shear stiffness κ·G·h per unit width in N/m, from the energy of the shear stress.

        In bending, equilibrium gives the stress τ(z) = (V/G_b)·S(z), where S is the first moment of
        the modulus beyond z. Equating the energies gives κGh = G_b²/∫ S²/G dz, which is 5/6·G·h for
        a single material.
        """
        # Four points integrate S² exactly, because it is a polynomial of degree 4 in z.
        nodes, weights = np.polynomial.legendre.leggauss(4)
        hp, z0 = self.ceramic_thickness_mm * MILLI, self.neutral_ratio
        moduli = (self.ceramic.modulus_pa, self.resonator_modulus_pa)
        shears = (self.ceramic_shear_pa, self.resonator_shear_pa)
        faces = (0.0, 1.0, 1.0 + self.beta)
        total, moment = 0.0, 0.0
        for modulus, shear, low, high in zip(moduli, shears, faces[:-1], faces[1:], strict=True):
            z = low + (high - low) * (1 + nodes) / 2
            s = moment - modulus * ((z - z0) ** 2 - (low - z0) ** 2) / 2
            total += float(np.sum(weights * s**2)) * (high - low) / 2 / shear
            moment -= modulus * ((high - z0) ** 2 - (low - z0) ** 2) / 2
        return self.rigidity_n_m**2 / (total * hp**5)

    def timoshenko_frequency_hz(self, half_wave_mm: npt.ArrayLike) -> Array:
        """Return the resonance frequency in Hz, including shear and rotary inertia.

        The paper does not use this beam model. The resonance is the lower root of Timoshenko's
        dispersion relation at q = π/(λ/2). For long waves, the resonance approaches that of
        `frequency_hz`. The small coupling between stretching and rotation is neglected.
        """
        q = np.pi / (positive("half_wave_mm", half_wave_mm, "mm") * MILLI)
        bending, shear = self.rigidity_n_m, self.shear_rigidity_n_m
        mass, rotary = self.mass_kg_m2, self.rotary_inertia_kg
        a = mass * rotary / shear
        b = mass + (rotary + mass * bending / shear) * q**2
        c = bending * q**4
        # This form of the lower root avoids cancellation for long waves.
        return np.asarray(np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * a * c))) / (2 * np.pi))

    def timoshenko_half_wave_mm(self, frequency_hz: float) -> float:
        """Return the half-wavelength in mm at which a Timoshenko beam resonates at a frequency.

        The solution is in closed form, because the dispersion relation is quadratic in q² for a
        given ω.
        """
        omega = 2 * np.pi * single("frequency_hz", frequency_hz, "Hz")
        bending, shear = self.rigidity_n_m, self.shear_rigidity_n_m
        mass, rotary = self.mass_kg_m2, self.rotary_inertia_kg
        b = (rotary + mass * bending / shear) * omega**2
        c = mass * omega**2 - mass * rotary * omega**4 / shear
        q_squared = (b + np.sqrt(b**2 + 4 * bending * c)) / (2 * bending)
        return float(np.pi / np.sqrt(q_squared) / MILLI)


def _cube_span(low: float, high: float, centre: float) -> float:
    """Return ∫ (z - centre)² dz from low to high."""
    return ((high - centre) ** 3 - (low - centre) ** 3) / 3
