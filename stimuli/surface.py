"""Define virtual surfaces, and conversions between peak and peak-to-peak amplitudes.

Amplitudes in experiments are peak to peak, whereas ``h_vib`` in the film models is a peak amplitude
(half the peak-to-peak value). For example, 2.3 µm peak to peak (h_vib = 1.15 µm), 30.5 kHz and h_r
= 0.6 µm give the squeeze number 15.9 printed in Section IV-A of the paper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, TypeVar

from slipscale.faults import UserError
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, Followed, Loop, Modulator

if TYPE_CHECKING:
    from slipscale.stimuli.quantities import Array

# Number or NumPy array.
Amplitude = TypeVar("Amplitude", float, "Array")
#: Label of surfaces that are not listed in a study.
UNLISTED = "S0"
PERIODS_SHOWN = 8  # number of vibration periods in pictures of a surface
#: Quantity that a finger sensor measures.
Sensor = Literal["position", "force"]
FilmModel = Literal["reynolds", "closed form"]


def peak_from_pp(level: Amplitude) -> Amplitude:
    """Convert a peak-to-peak amplitude in µm to a peak amplitude in µm.

    >>> peak_from_pp(2.3)
    1.15
    """
    return level / 2


def pp_from_peak(amplitude_um_peak: Amplitude) -> Amplitude:
    """Convert a peak amplitude in µm to a peak-to-peak amplitude in µm."""
    return amplitude_um_peak * 2


class Stimulus(Protocol):
    """Common interface for stimuli: surfaces, textures, and textures with a varied parameter."""

    @property
    def label(self) -> str:
        """Code that does not reveal the level."""

    @property
    def name(self) -> str:
        """Name of a texture in the data; empty for other stimuli."""

    @property
    def level(self) -> float:
        """Level in the study's quantity."""

    @property
    def settled_level(self) -> float:
        """Level at which a plate settles, in the quantity of the plate."""

    @property
    def made(self) -> Surface:
        """Surface that a plate presents."""

    def turned(self, level: float) -> Stimulus:
        """Return the stimulus at a different level, with a label that does not reveal the level."""


class Surface(Stimulus, Protocol):
    """Common interface for surfaces that a plate can present (a single amplitude or a texture)."""

    @property
    def level(self) -> float:
        """Largest amplitude in µm peak to peak, which is checked against the plate's limits."""

    @property
    def sensor(self) -> Sensor | None:
        """Sensor that can control the surface's amplitude, or None."""

    @property
    def needs_sensor(self) -> bool:
        """Whether the surface can be presented only if its sensor is available."""

    def shown(self, share: float) -> float:
        """Return the height of the drawn curve at a horizontal position from 0 to 1."""

    def change(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return the loop that starts at the trigger, or None if there is no trigger."""

    def loop(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return the loop that is played if the finger is not measured, or None."""

    def followed(self, modulator: Modulator = DEFAULT_MODULATOR) -> Followed | None:
        """Predict how well amplitude and friction follow the commanded changes.

        Return None if the amplitude is constant.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualSurface:
    """Surface that the plate presents by vibrating at a constant amplitude.

    Parameters
    ----------
    level : float
        Vibration amplitude in µm peak to peak; finite and not negative.
    label : str
        Code used for the operator and in the data, which does not reveal the amplitude ("A", "B",
        ...).

    Raises
    ------
    UserError
        If the amplitude is negative, infinite or not a number.
    """

    level: float
    label: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.level) and self.level >= 0):
            raise UserError(
                "surface '{label}': level must be a finite number of 0 or more, but is {level}",
                label=self.label,
                level=self.level,
            )

    @property
    def name(self) -> str:
        """Always empty, because only textures have names."""
        return ""

    @property
    def sensor(self) -> Sensor | None:
        """Always None, because the amplitude does not depend on the finger."""
        return None

    @property
    def needs_sensor(self) -> bool:
        """Always False, because nothing has to be measured."""
        return False

    @property
    def settled_level(self) -> float:
        """Level at which the plate settles; equal to ``level``, because the surface is constant."""
        return self.level

    @property
    def made(self) -> VirtualSurface:
        """The surface itself, because a plate presents it unchanged."""
        return self

    def turned(self, level: float) -> VirtualSurface:
        """Return a surface with a different amplitude and a label that does not reveal it."""
        return VirtualSurface(level=level, label=UNLISTED)

    @property
    def amplitude_um_peak(self) -> float:
        """Amplitude in µm peak, h_vib in the squeeze-film model."""
        return peak_from_pp(self.level)

    def shown(self, share: float) -> float:
        """Return the height of the drawn vibration at a horizontal position from 0 to 1."""
        return self.level * math.sin(2 * math.pi * PERIODS_SHOWN * share)

    def loop(
        self,
        modulator: Modulator = DEFAULT_MODULATOR,  # noqa: ARG002 - the same on any plate
    ) -> Loop | None:
        """Return None, because a constant amplitude needs no loop."""
        return None

    change = loop

    def followed(
        self,
        modulator: Modulator = DEFAULT_MODULATOR,  # noqa: ARG002 - the same on any plate
    ) -> Followed | None:
        """Return None, because the amplitude does not change."""
        return None

    def predicted_relative_friction(
        self,
        *,
        roughness_um: float = 0.6,
        frequency_hz: float = 30_500.0,
        normal_force_n: float = 0.5,
        model: FilmModel = "reynolds",
    ) -> float:
        """Predict friction relative to the plate at rest with a squeeze-film model.

        Parameters
        ----------
        roughness_um : float
            Average roughness h_r of the plate. The default is from Section IV-A of the paper.
        frequency_hz : float
            Vibration frequency. The default is the frequency of the prototype in the paper.
        normal_force_n : float
            Force of the finger. The default is from Section II-C of the paper.
        model : {"reynolds", "closed form"}
            Full Reynolds equation (3), or closed form (13). At the paper's working point, the
            closed form overestimates the film by a factor of 1.3 to 1.5
            (docs/explanation/squeeze-film.md).

        Returns
        -------
        float
            Relative friction µ'/µ of equation (15): 1 without an effect, negative if the finger
            levitates.

        Examples
        --------
        >>> round(VirtualSurface(level=2.3).predicted_relative_friction(), 2)
        0.74
        """
        # Imported late, because NumPy is slow to import.
        from slipscale.stimuli.film import reynolds, squeeze_film

        peak = self.amplitude_um_peak
        if model == "closed form":
            friction = squeeze_film.relative_friction(
                peak, roughness_um, frequency_hz, normal_force_n=normal_force_n
            )
        else:
            point = reynolds.WorkingPoint(
                amplitude_um_peak=peak, roughness_um=roughness_um, frequency_hz=frequency_hz
            )
            friction = reynolds.relative_friction(point, normal_force_n)
        return float(friction.relative_friction)
