"""Compute the samples of a sine wave with a ramped amplitude."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

RAMP_S = 0.025  # from silence to full scale, to avoid a click


class Carrier:
    """Sine wave whose phase and amplitude are continuous across blocks of samples.

    Parameters
    ----------
    rate_hz : float
        Samples per second.

    Attributes
    ----------
    frequency_hz : float
        Frequency of the sine wave; can be changed at any time without a phase jump.
    target : float
        Target amplitude, 0 to 1 (full scale).
    level : float
        Amplitude of the last sample.
    """

    def __init__(self, rate_hz: float) -> None:
        self.rate_hz = rate_hz
        self.frequency_hz = 0.0
        self.target = 0.0
        self.level = 0.0
        self._phase = 0.0

    def samples(self, count: int) -> NDArray[np.float32]:
        """Return the next samples, with the amplitude ramping towards the target.

        Returns
        -------
        ndarray, shape (count,)
            Samples between -1 and 1.
        """
        target, step = self.target, 1 / (RAMP_S * self.rate_hz)
        far = np.arange(1, count + 1) * step
        levels = self.level + np.clip(target - self.level, -far, far)
        turn = 2 * np.pi * self.frequency_hz / self.rate_hz
        made = levels * np.sin(self._phase + turn * np.arange(1, count + 1))
        self._phase = float((self._phase + turn * count) % (2 * np.pi))
        self.level = float(levels[-1]) if count else self.level
        return np.asarray(made, np.float32)
