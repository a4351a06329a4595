"""Generate pink noise for headphones, so that participants do not hear the plate.

Pink noise has equal power in every octave: its power spectral density falls as 1/f, by 3.01 dB per
octave. The noise is generated in the frequency domain. It is therefore periodic and can be repeated
without a gap for a whole session.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from slipscale.faults import UserError

FULL_SCALE_SINE_RMS = math.sqrt(0.5)


def pink_noise(
    *,
    level_db: float,
    seed: int,
    duration_s: float = 10.0,
    sample_rate_hz: float = 48_000.0,
    low_hz: float = 20.0,
    high_hz: float = 20_000.0,
) -> NDArray[np.float32]:
    """Generate pink noise that can be repeated without a gap.

    Parameters
    ----------
    level_db : float
        Root mean square in dB relative to a full-scale sine, as in AES17; must be below 0.
    seed : int
        Random seed; the same seed gives the same noise.
    duration_s : float
        Duration after which the noise repeats.
    sample_rate_hz : float
        Samples per second.
    low_hz, high_hz : float
        Frequency band of the noise; ``high_hz`` is limited to half the sample rate.

    Returns
    -------
    ndarray of float32, shape (round(duration_s * sample_rate_hz),)
        Samples; full scale is -1 to 1.

    Raises
    ------
    UserError
        If the level is not finite, or so high that a peak would exceed full scale. The noise is
        never clipped, because clipping would change its spectrum.
    """
    if not math.isfinite(level_db):
        raise UserError(
            "masking noise: level_db must be a finite number of dB, but is {level_db}",
            level_db=level_db,
        )
    samples = round(duration_s * sample_rate_hz)
    frequency_hz = np.fft.rfftfreq(samples, 1 / sample_rate_hz)
    band = (frequency_hz >= low_hz) & (frequency_hz <= high_hz)
    band[-1] = False  # The bin at half the sample rate has no free phase.
    if not band.any():
        raise UserError(
            "masking noise: no frequency between {low_hz} and {high_hz} Hz fits {duration_s} s "
            "at {sample_rate_hz} Hz",
            low_hz=low_hz,
            high_hz=high_hz,
            duration_s=duration_s,
            sample_rate_hz=sample_rate_hz,
        )
    generator = np.random.default_rng(seed)
    white = generator.standard_normal((2, int(band.sum())))
    spectrum = np.zeros(frequency_hz.size, dtype=complex)
    spectrum[band] = (white[0] + 1j * white[1]) / np.sqrt(frequency_hz[band])
    noise = np.fft.irfft(spectrum, samples)
    noise *= FULL_SCALE_SINE_RMS * 10 ** (level_db / 20) / np.sqrt(np.mean(noise**2))
    peak = float(np.abs(noise).max())
    if peak > 1:
        highest_db = math.floor(10 * (level_db - 20 * math.log10(peak))) / 10
        raise UserError(
            "masking noise: level_db must be at most {highest_db:.1f}, but is {level_db:g}: the "
            "noise's peaks would exceed full scale",
            highest_db=highest_db,
            level_db=level_db,
        )
    return noise.astype(np.float32)


def ramp(gain: float, target: float, samples: int, fade_samples: int) -> NDArray[np.float64]:
    """Return gains that change linearly from ``gain`` to ``target`` and then remain constant.

    Parameters
    ----------
    gain, target : float
        Gains before and at the end of the ramp, from 0 (silence) to 1 (full level of the noise).
    samples : int
        Number of gains.
    fade_samples : int
        Number of samples of a fade from 0 to 1; if 0, the gain changes immediately.

    Returns
    -------
    ndarray, shape (samples,)
        Gains, from one step after ``gain``. The next ramp starts at the last value.
    """
    step = math.copysign(1 / max(fade_samples, 1), target - gain)
    path = gain + step * np.arange(1, samples + 1, dtype=float)
    return np.clip(path, min(gain, target), max(gain, target))
