"""Generate sounds for testing whether participants wear headphones that play in both ears.

In each trial, one of three tones is quieter, and one of the other two has opposite phase in the two
ears. With headphones, the phase hardly affects loudness. With loudspeakers, opposite phases cancel
each other in the air, so this tone sounds quietest. Source: Woods, Siegel, Traer and McDermott
(2017), Headphone screening to facilitate web-based auditory experiments, Attention, Perception, &
Psychophysics 79, 2064-2072, doi:10.3758/s13414-017-1361-2, "Method".
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from slipscale.faults import UserError
from slipscale.stimuli.masking_noise import pink_noise

Ears = Literal["left", "right", "both"]
EARS: tuple[Ears, ...] = ("left", "right", "both")
# In front of two loudspeakers, 200 Hz cancels over a wide area (Woods et al., 2017).
TONE_HZ, TONE_S, RAMP_S, GAP_S = 200.0, 1.0, 0.1, 0.5
QUIETER_DB = 6.0
TONES = 3
NOISE_S = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Tones:
    """Sequence of three tones.

    Parameters
    ----------
    quiet, antiphase : int
        Number (1, 2 or 3) of the quieter tone and of the loud tone in antiphase.
    level_db : float
        Level of the loud tones relative to a full-scale sine.
    """

    quiet: int
    antiphase: int
    level_db: float

    def __post_init__(self) -> None:
        places = range(1, TONES + 1)
        if self.quiet == self.antiphase or not {self.quiet, self.antiphase} <= set(places):
            raise UserError(
                "headphone test: tone {quiet} quiet and tone {antiphase} in antiphase; expected "
                "two different tones from 1 to 3",
                quiet=self.quiet,
                antiphase=self.antiphase,
            )

    @property
    def duration_s(self) -> float:
        """Total duration of the tones."""
        return TONES * TONE_S + (TONES - 1) * GAP_S

    def samples(self, sample_rate_hz: float) -> NDArray[np.float32]:
        """Return both channels, shape (n, 2), full scale -1 to 1."""
        time_s = np.arange(round(TONE_S * sample_rate_hz)) / sample_rate_hz
        rising = np.sin(math.pi / 2 * np.clip(time_s / RAMP_S, 0, 1)) ** 2
        tone = np.sin(2 * math.pi * TONE_HZ * time_s) * rising * rising[::-1]
        gap = np.zeros((round(GAP_S * sample_rate_hz), 2))
        parts = []
        for number in range(1, TONES + 1):
            down_db = QUIETER_DB if number == self.quiet else 0.0
            left = tone * 10 ** ((self.level_db - down_db) / 20)
            right = -left if number == self.antiphase else left
            parts += [np.column_stack((left, right)), gap]
        return np.concatenate(parts[:-1]).astype(np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseInEar:
    """Masking noise of limited duration in one ear or both ears.

    Parameters
    ----------
    ear : {"left", "right", "both"}
    level_db : float
        Level of the study's masking noise.
    seed : int
        Seed of the study's masking noise.
    """

    ear: Ears
    level_db: float
    seed: int

    @property
    def duration_s(self) -> float:
        """Duration of the noise."""
        return NOISE_S

    def samples(self, sample_rate_hz: float) -> NDArray[np.float32]:
        """Return both channels, shape (n, 2), full scale -1 to 1."""
        noise = pink_noise(level_db=self.level_db, seed=self.seed, sample_rate_hz=sample_rate_hz)
        noise = noise[: round(NOISE_S * sample_rate_hz)]
        time_s = np.arange(noise.size) / sample_rate_hz
        ends = np.clip(np.minimum(time_s, time_s[::-1]) / RAMP_S, 0, 1)
        heard = (self.ear in ("left", "both"), self.ear in ("right", "both"))
        return np.column_stack([noise * ends * on for on in heard]).astype(np.float32)


HeadphoneSound = Tones | NoiseInEar
