"""What is presented: a virtual surface, and the one place where amplitudes change convention.

The experiment's amplitudes are peak to peak, the film's ``h_vib`` is peak (half of it): only
then is the squeeze number 15.9 at 30.5 kHz with h_r = 0.6 µm, as printed on the paper's
Section IV-A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from faults import UserError


def peak_from_pp(amplitude_um_pp: float) -> float:
    """Return the peak amplitude in µm of a peak-to-peak amplitude in µm.

    >>> peak_from_pp(2.3)
    1.15
    """
    return amplitude_um_pp / 2


def pp_from_peak(amplitude_um_peak: float) -> float:
    """Return the peak-to-peak amplitude in µm of a peak amplitude in µm."""
    return amplitude_um_peak * 2


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualSurface:
    """A surface made by vibrating the plate with one amplitude.

    Parameters
    ----------
    amplitude_um_pp : float
        Vibration amplitude in µm, peak to peak; finite, not negative.
    label : str
        A code for the operator and the data that does not tell the amplitude ("A", "B", ...).

    Raises
    ------
    UserError
        The amplitude is negative, infinite or not a number.
    """

    amplitude_um_pp: float
    label: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.amplitude_um_pp) and self.amplitude_um_pp >= 0):
            raise UserError(
                f"surface '{self.label}': amplitude_um_pp is {self.amplitude_um_pp}, "
                "expected a finite number of µm peak to peak, 0 or more"
            )

    @property
    def amplitude_um_peak(self) -> float:
        """The amplitude in µm, peak: what the squeeze-film model calls h_vib."""
        return peak_from_pp(self.amplitude_um_pp)
