"""Virtual surfaces, and the only place in which amplitudes change convention.

Amplitudes in the experiment are peak to peak; the film's ``h_vib`` is peak (half of that). Only
with this convention is the squeeze number 15.9 at 30.5 kHz with h_r = 0.6 µm, as printed in
Section IV-A of the paper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, TypeVar

from slipscale.faults import UserError
from slipscale.stimuli.modulation import DEFAULT_MODULATOR, Followed, Loop, Modulator

if TYPE_CHECKING:
    from slipscale.stimuli.quantities import Array

# A number, or a NumPy array of them.
Amplitude = TypeVar("Amplitude", float, "Array")
#: Label of a surface that a study does not list.
UNLISTED = "S0"
PERIODS_SHOWN = 8  # of the vibration, in pictures of a surface
#: What is measured of a finger.
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
    """A stimulus that a protocol can present: a plain surface, a texture, or a varied parameter."""

    @property
    def label(self) -> str:
        """A code that does not reveal the level."""

    @property
    def name(self) -> str:
        """The name of a texture in the data; empty for others."""

    @property
    def level(self) -> float:
        """The level in the study's quantity."""

    @property
    def settled_level(self) -> float:
        """The level at which a plate settles to present it, in the plate's quantity."""

    @property
    def made(self) -> Surface:
        """The surface that a plate is commanded to present."""

    def turned(self, level: float) -> Stimulus:
        """Return the stimulus at another level, with a label that does not reveal it."""


class Surface(Stimulus, Protocol):
    """A surface that a plate presents: one amplitude, or a texture."""

    @property
    def level(self) -> float:
        """Largest amplitude in µm, peak to peak, which is checked against the plate's limits."""

    @property
    def sensor(self) -> Sensor | None:
        """The sensor by which the surface follows the finger; None if it does not."""

    @property
    def needs_sensor(self) -> bool:
        """Whether the surface cannot be presented without that sensor."""

    def shown(self, share: float) -> float:
        """Return the height at a point (0 to 1) in a picture of the surface."""

    def change(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return what is played when the finger reaches a trigger; None without a trigger."""

    def loop(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return the loop for a plate that does not track the finger; None if none is needed."""

    def followed(self, modulator: Modulator = DEFAULT_MODULATOR) -> Followed | None:
        """Return how well plate and friction follow the surface; None if nothing changes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualSurface:
    """A surface presented by vibrating the plate with one amplitude.

    Parameters
    ----------
    level : float
        Vibration amplitude in µm, peak to peak; finite, not negative.
    label : str
        A code for the operator and the data that does not reveal the amplitude ("A", "B", ...).

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
                f"surface '{self.label}': its level is {self.level}, expected a finite number, "
                "0 or more"
            )

    @property
    def name(self) -> str:
        """Empty: only textures have names."""
        return ""

    @property
    def sensor(self) -> Sensor | None:
        """None, because the surface does not follow the finger."""
        return None

    @property
    def needs_sensor(self) -> bool:
        """False, because nothing has to be measured."""
        return False

    @property
    def settled_level(self) -> float:
        """The level at which the plate settles, its only amplitude."""
        return self.level

    @property
    def made(self) -> VirtualSurface:
        """The surface that a plate is commanded to present: this one."""
        return self

    def turned(self, level: float) -> VirtualSurface:
        """Return the surface with another amplitude and a label that does not reveal it."""
        return VirtualSurface(level=level, label=UNLISTED)

    @property
    def amplitude_um_peak(self) -> float:
        """The amplitude in µm, peak: h_vib in the squeeze-film model."""
        return peak_from_pp(self.level)

    def shown(self, share: float) -> float:
        """Return the height at a point (0 to 1) in a picture of the vibration."""
        return self.level * math.sin(2 * math.pi * PERIODS_SHOWN * share)

    def loop(
        self,
        modulator: Modulator = DEFAULT_MODULATOR,  # noqa: ARG002 - the same on any plate
    ) -> Loop | None:
        """Return None: there is nothing to play."""
        return None

    change = loop

    def followed(
        self,
        modulator: Modulator = DEFAULT_MODULATOR,  # noqa: ARG002 - the same on any plate
    ) -> Followed | None:
        """Return None: nothing changes."""
        return None

    def predicted_relative_friction(
        self,
        *,
        roughness_um: float = 0.6,
        frequency_hz: float = 30_500.0,
        normal_force_n: float = 0.5,
        model: FilmModel = "reynolds",
    ) -> float:
        """Return the squeeze film's prediction of friction relative to the plate at rest.

        Parameters
        ----------
        roughness_um : float
            Average roughness h_r of the plate; the default is from Section IV-A.
        frequency_hz : float
            Vibration frequency; the default is that of the paper's prototype.
        normal_force_n : float
            Force of the finger; the default is from Section II-C.
        model : {"reynolds", "closed form"}
            Reynolds' equation (3) in full, or the closed form (13), which at the paper's working
            point makes the film 1.3 to 1.5 times too strong (docs/explanation/squeeze-film.md).

        Returns
        -------
        float
            µ'/µ of equation (15): 1 for no effect, below 0 if the finger levitates.

        Examples
        --------
        >>> round(VirtualSurface(level=2.3).predicted_relative_friction(), 2)
        0.74
        """
        # NumPy loads slowly, so it is imported only for the physics.
        from slipscale.stimuli.film import reynolds, squeeze_film  # noqa: PLC0415

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
