"""Repeat the paper's numerical study (Section III-C, Figs. 9, 11 and 12)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.optimize import root_scalar

from slipscale.faults import UserError
from slipscale.hardware.plate.beam import BeamSection
from slipscale.hardware.plate.finite_elements import Electrodes
from slipscale.hardware.plate.geometry import DEFAULT, HALF_WAVE, Density, Layout
from slipscale.hardware.plate.vibration import Modes, modes, response_um
from slipscale.stimuli.quantities import MILLI, Array, positive
from slipscale.stimuli.surface import pp_from_peak

HALF_WAVES_MM = (9.0, 10.0, 11.0, 12.0, 14.0, 16.0, 20.0)  # Section III-C-1
MODE_COUNT = 12  # modes to superpose; with 36, the peak of Fig. 12 moves by 0.01 %
_NEAR_MODES = 8
_TOLERANCE_MM = 1e-6
_ITERATIONS_MAX = 20  # Fig. 9 requires about six iterations.


def half_wave_modes(layout: Layout, density: Density = HALF_WAVE) -> Modes:
    """Compute the modes of a half-wave section around its bending resonance."""
    near = BeamSection.plane_strain(
        layout.ceramic,
        layout.resonator,
        ceramic_thickness_mm=layout.ceramic_thickness_mm,
        resonator_thickness_mm=layout.resonator_thickness_mm,
    ).timoshenko_frequency_hz(layout.length_mm)
    return modes(layout, float(near), _NEAR_MODES, density=density)


def half_wave_frequency_hz(layout: Layout, density: Density = HALF_WAVE) -> float:
    """Return the bending resonance of a half-wave section in Hz (squares in Fig. 9).

    The mode is identified by its shape, cos(πx/l), which is uniform across the width. For half
    waves of 9 and 10 mm, a width-stretching mode (36.7 kHz for 49 mm) has a lower frequency than
    the bending mode. Near 11 mm, the two modes mix.
    """
    found = half_wave_modes(layout, density)
    top = found.parts.at(z=found.parts.thickness_m)
    bent = np.cos(np.pi * found.parts.nodes[0, top] / (layout.length_mm * MILLI))
    return float(found.frequency_hz[np.argmax(np.abs(found.shape[:, 2, top] @ bent))])


def half_wave_for_frequency_mm(
    frequency_hz: float, width_mm: float = 49.0, density: Density = HALF_WAVE
) -> float:
    """Find the half-wavelength in mm at which a section resonates at a given frequency.

    Raises
    ------
    UserError
        If the secant method finds no solution near that of the beam model.
    """
    wanted = float(positive("frequency_hz", frequency_hz, "Hz"))

    def excess(half_wave_mm: float) -> float:
        section = Layout.half_wave(half_wave_mm, width_mm)
        return float(np.log(half_wave_frequency_hz(section, density) / wanted))

    first = BeamSection.plane_strain().half_wave_for_frequency_mm(wanted)
    found = root_scalar(
        excess,
        method="secant",
        x0=first,
        x1=0.97 * first,
        xtol=_TOLERANCE_MM,
        maxiter=_ITERATIONS_MAX,
    )
    if not found.converged:
        raise UserError(
            "half-wavelength for {wanted:g} Hz: not found in {iterations} iterations of the "
            "secant method, which began at {first:.3g} mm; expected a frequency from the "
            "paper's Fig. 9",
            wanted=wanted,
            iterations=_ITERATIONS_MAX,
            first=first,
        )
    return float(found.root)


@dataclass(frozen=True, slots=True, kw_only=True)
class Harmonic:
    """Harmonic response at one point of the touch surface (Fig. 12).

    Parameters
    ----------
    frequency_hz : ndarray
        Drive frequencies.
    amplitude_um_peak : ndarray
        Vertical peak amplitude at this point in µm.
    """

    frequency_hz: Array
    amplitude_um_peak: Array

    @property
    def peak_hz(self) -> float:
        """Frequency in Hz at which the amplitude is largest."""
        return self._vertex()[0]

    @property
    def peak_um_pp(self) -> float:
        """Largest amplitude, µm peak to peak."""
        return pp_from_peak(self._vertex()[1])

    def _vertex(self) -> tuple[float, float]:
        """Return the vertex of the parabola through the three largest samples."""
        top = int(np.argmax(self.amplitude_um_peak[1:-1])) + 1
        left, middle, right = self.amplitude_um_peak[top - 1 : top + 2]
        bend = left - 2 * middle + right
        shift = 0.5 * (left - right) / bend if bend else 0.0
        step = self.frequency_hz[top + 1] - self.frequency_hz[top]
        return float(self.frequency_hz[top] + shift * step), float(
            middle - 0.25 * (left - right) * shift
        )


def plate_modes(
    layout: Layout,
    *,
    near_hz: float = 35_000.0,
    density: Density = DEFAULT,
    electrodes: Electrodes = "shorted",
) -> Modes:
    """Compute the modes of a whole plate for its harmonic response."""
    return modes(layout, near_hz, MODE_COUNT, density=density, electrodes=electrodes)


def harmonic(
    found: Modes,
    *,
    voltage_v: float = 15.0,
    loss_factor: npt.ArrayLike | None = None,
    where_mm: tuple[float, float] | None = None,
    half_band: float = 0.06,
) -> Harmonic:
    """Compute the harmonic response around the driven mode.

    Parameters
    ----------
    found : Modes
        Modes returned by `plate_modes`.
    voltage_v : float
        Drive, V peak.
    loss_factor : array_like, optional
        Loss factor 1/Q for all modes, or per mode (``found.loss_from_ceramic()``). The default is
        the value of the plate's ceramic, 1/60 in Table II.
    where_mm : tuple of 2 floats, optional
        Position of the point. The default is the edge antinode nearest to the centre (x = 0 for an
        odd number of ceramics, y = width/2), at which the amplitude of the paper's plate is 1.5
        times that in the middle.
    half_band : float
        Half-width of the frequency band, as a fraction of the driven mode's frequency.
    """
    layout = found.parts.layout
    centre = found.frequency_hz[found.driven]
    frequency = centre * np.linspace(1 - half_band, 1 + half_band, 2001)
    loss = 1 / layout.ceramic.quality_factor if loss_factor is None else loss_factor
    point = where_mm or (layout.antinode_x_mm, layout.width_mm / 2)
    amplitude = response_um(found, frequency, voltage_v, loss, point)
    return Harmonic(frequency_hz=frequency, amplitude_um_peak=np.abs(amplitude))


@lru_cache(maxsize=8)
def prototype_modes(
    *, continuous: bool = False, density: Density = DEFAULT, electrodes: Electrodes = "shorted"
) -> Modes:
    """Compute the modes of the paper's plate. Results are cached."""
    return plate_modes(
        Layout.prototype(continuous=continuous), density=density, electrodes=electrodes
    )
