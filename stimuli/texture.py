"""Textures: surfaces whose amplitude follows the finger, as ridges and grooves of friction.

The paper's introduction and conclusion name them: a slippery feeling that is modulated in space
is taken for relief. A grating is a function of position; for a finger of known speed it becomes a
sequence of commands, within what the plate and its line can follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args

from slipscale.faults import UserError
from slipscale.stimuli.modulation import (
    DEFAULT_MODULATOR,
    STEPS_MAX,
    AmplitudeStep,
    Loop,
    Modulator,
)

if TYPE_CHECKING:
    from collections.abc import Callable

Waveform = Literal["sine", "square", "triangle", "sawtooth"]


class _Wave(NamedTuple):
    """A wave: its value (-1 to 1) at a phase (0 to 1), and the fewest steps that tell it."""

    value: Callable[[float], float]
    steps_min: int


_WAVES: dict[Waveform, _Wave] = {
    "sine": _Wave(lambda phase: math.sin(2 * math.pi * phase), 8),
    "square": _Wave(lambda phase: 1.0 if phase < 0.5 else -1.0, 2),  # noqa: PLR2004 - half a period
    "triangle": _Wave(lambda phase: 1 - 4 * abs(((phase + 0.25) % 1) - 0.5), 8),
    "sawtooth": _Wave(lambda phase: 2 * phase - 1, 8),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Grating:
    """A grating of friction along the stroke of the finger.

    Parameters
    ----------
    spatial_period_mm : float
        Length of one period, mm.
    mean_level : float
        Vibration amplitude in the middle of the wave, µm peak to peak.
    depth_level : float
        Swing of the amplitude to either side of the mean, µm peak to peak: from mean - depth to
        mean + depth. At most the mean, for no amplitude is negative.
    waveform : {"sine", "square", "triangle", "sawtooth"}
        How the amplitude goes along a period.
    label : str
        A code that does not tell the texture.
    name : str
        What the study calls it, for the data.
    finger_speed_mm_s : float
        Speed of the finger that is assumed where the plate does not track it; above 0.

    Raises
    ------
    UserError
        A length, amplitude or speed is out of range, or no such wave form is known.
    """

    spatial_period_mm: float
    mean_level: float
    depth_level: float
    waveform: Waveform = "sine"
    label: str = ""
    name: str = ""
    finger_speed_mm_s: float = 50.0

    def __post_init__(self) -> None:
        where = self._where
        if not (math.isfinite(self.spatial_period_mm) and self.spatial_period_mm > 0):
            raise UserError(
                f"{where}: spatial_period_mm is {self.spatial_period_mm}, expected above 0 mm"
            )
        if not (math.isfinite(self.mean_level) and self.mean_level >= 0):
            raise UserError(
                f"{where}: mean_um_pp is {self.mean_level}, expected 0 or more µm peak to peak"
            )
        if not 0 <= self.depth_level <= self.mean_level:
            raise UserError(
                f"{where}: depth_um_pp is {self.depth_level}, expected from 0 to the mean, "
                f"{self.mean_level} µm peak to peak"
            )
        if self.waveform not in _WAVES:
            known = ", ".join(get_args(Waveform))
            raise UserError(f"{where}: waveform is '{self.waveform}', expected one of: {known}")
        if not (math.isfinite(self.finger_speed_mm_s) and self.finger_speed_mm_s > 0):
            raise UserError(
                f"{where}: finger_speed_mm_s is {self.finger_speed_mm_s}, expected above 0 mm/s"
            )

    @property
    def _where(self) -> str:
        return f"texture '{self.name or self.label}'"

    @property
    def level(self) -> float:
        """The largest amplitude, µm peak to peak."""
        return self.mean_level + self.depth_level

    @property
    def lowest_level(self) -> float:
        """The smallest amplitude, µm peak to peak."""
        return self.mean_level - self.depth_level

    def level_at(self, position_mm: float) -> float:
        """Return the amplitude at a place of the stroke, µm peak to peak."""
        phase = (position_mm / self.spatial_period_mm) % 1.0
        return self.mean_level + self.depth_level * _WAVES[self.waveform].value(phase)

    def modulation_hz(self, finger_speed_mm_s: float) -> float:
        """Return how often a second a finger of this speed crosses a period."""
        return abs(finger_speed_mm_s) / self.spatial_period_mm

    def envelope(
        self, finger_speed_mm_s: float, duration_s: float, modulator: Modulator = DEFAULT_MODULATOR
    ) -> tuple[AmplitudeStep, ...]:
        """Return the commands that make the grating under a finger of constant speed.

        Parameters
        ----------
        finger_speed_mm_s : float
            Speed of the finger; negative is backwards. The stroke starts at position 0.
        duration_s : float
            Length of the stroke in time.
        modulator : Modulator
            What the plate's resonance and the line allow.

        Returns
        -------
        tuple of AmplitudeStep
            In order of time, from 0; each amplitude is the wave's at the middle of its step.

        Raises
        ------
        UserError
            The finger crosses the grating faster than plate or line can follow.
        """
        if not math.isfinite(finger_speed_mm_s):
            raise UserError(
                f"{self._where}: finger_speed_mm_s is {finger_speed_mm_s}, "
                "expected a finite number of mm/s"
            )
        if not (math.isfinite(duration_s) and duration_s > 0):
            raise UserError(f"{self._where}: duration_s is {duration_s}, expected above 0 s")
        rate = self.modulation_hz(finger_speed_mm_s)
        if rate == 0 or self.depth_level == 0:
            return (AmplitudeStep(0.0, self.level_at(0.0)),)
        fewest = _WAVES[self.waveform].steps_min
        fastest = modulator.fastest_hz(fewest)
        if rate > fastest:
            raise UserError(
                f"{self._where}: a finger at {abs(finger_speed_mm_s):g} mm/s crosses "
                f"{rate:.3g} periods a second, the plate and its line follow {fastest:.3g} at "
                f"most: expected a finger up to {fastest * self.spatial_period_mm:.3g} mm/s or a "
                f"period from {abs(finger_speed_mm_s) / fastest:.3g} mm"
            )
        most = min(1 / (rate * modulator.shortest_step_s) + 1e-9, STEPS_MAX)
        steps = fewest if self.waveform == "square" else math.floor(most)
        step_s = 1 / (rate * steps)
        count = math.ceil(duration_s / step_s - 1e-9)
        return tuple(
            AmplitudeStep(i * step_s, self.level_at((i + 0.5) * step_s * finger_speed_mm_s))
            for i in range(count)
        )

    def loop(self, modulator: Modulator = DEFAULT_MODULATOR) -> Loop | None:
        """Return one period under a finger of the assumed speed; None for a grating of no depth.

        Raises
        ------
        UserError
            The finger crosses the grating faster than plate or line can follow.
        """
        if self.depth_level == 0:
            return None
        period_s = 1 / self.modulation_hz(self.finger_speed_mm_s)
        steps = self.envelope(self.finger_speed_mm_s, period_s, modulator)
        step_s = period_s / len(steps)
        return Loop(
            levels=tuple(step.level for step in steps),
            step_s=step_s,
            edge_s=min(modulator.edge_s, step_s),  # the same but for rounding, at the fastest
            mean_level=self.mean_level,
        )
