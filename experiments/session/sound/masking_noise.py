"""Play masking noise in the headphones while the plate may be audible.

A session starts and stops the noise with the methods of `Noise`. The sound device is opened only by
`MaskingNoise`, and only when the noise starts.
"""

from __future__ import annotations

import threading
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from slipscale.faults import RigError
from slipscale.faults.message import Message
from slipscale.stimuli.masking_noise import pink_noise, ramp

REMEDY = "plug in headphones and select them as the system output, or turn masking noise off"
COMMON_RATE_HZ = 48_000.0
CHANNELS = 2
STALL_S = 1.0  # maximum time for a device to finish after a fade
NoiseState = Literal["absent", "silent", "playing"]


class Noise(Protocol):
    """Common interface for masking noise."""

    @property
    def state(self) -> NoiseState:
        """The current state of the noise: "absent", "silent" or "playing"."""

    def start(self) -> None:
        """Fade the noise in unless it is playing, and return when it has reached its level."""

    def stop(self) -> None:
        """Fade out if the noise is playing."""


class NoNoise:
    """A silent replacement for the masking noise, for studies that use no noise."""

    state: NoiseState = "absent"

    def start(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""


def check_device() -> str | None:
    """Describe a fault in the sound output and its remedy; return None if the output works."""
    try:
        import sounddevice
    except OSError:
        return "PortAudio is missing: install it (Debian: apt-get install libportaudio2)"
    try:
        device = sounddevice.query_devices(kind="output")
        rate_hz = device["default_samplerate"]
        sounddevice.check_output_settings(samplerate=rate_hz, channels=CHANNELS)
    except (sounddevice.PortAudioError, ValueError) as error:
        return Message("no sound can be played ({error}): {remedy}", error=error, remedy=REMEDY)
    return None


def device_rate_hz() -> float:
    """Return the output device's sample rate, or a common rate if no sound can be played."""
    if check_device():
        return COMMON_RATE_HZ
    import sounddevice

    return float(sounddevice.query_devices(kind="output")["default_samplerate"])


class Playback:
    """Supplies noise with fades to the sound card's thread, block by block.

    Parameters
    ----------
    noise : ndarray, shape (n,)
        One period of the noise.
    fade_samples : int
        Number of samples in a fade from silence to full level.
    """

    def __init__(self, noise: NDArray[np.float32], fade_samples: int) -> None:
        self._noise = noise
        self._fade_samples = fade_samples
        self._position = 0
        self._gain = 0.0
        self.target = 0.0
        self.silent = threading.Event()
        self.level = threading.Event()

    def fill(self, block: NDArray[np.float32]) -> None:
        """Write the next samples into ``block``, shape (samples, channels)."""
        samples = len(block)
        gains = ramp(self._gain, self.target, samples, self._fade_samples)
        places = (self._position + np.arange(samples)) % self._noise.size
        block[:] = (self._noise[places] * gains)[:, None]
        self._position = int((self._position + samples) % self._noise.size)
        self._gain = float(gains[-1]) if samples else self._gain
        if self._gain == self.target:
            (self.silent if self.target == 0.0 else self.level).set()


class MaskingNoise:
    """Pink noise in both ears, from `start` to `stop`.

    Parameters
    ----------
    level_db : float
        Root mean square in dB relative to a full-scale sine. Measure the level at the ear with a
        sound level meter, because it depends on the headphones and the system's volume.
    fade_s : float
        Duration of the fades.
    seed : int
        The same seed gives the same noise.

    Raises
    ------
    UserError
        If the level is too high and the noise would clip.
    """

    def __init__(self, level_db: float, fade_s: float, seed: int) -> None:
        self._fade_s = fade_s
        # The noise is generated now, so that a clipping level is reported before the participant
        # arrives.
        self._rate_hz = device_rate_hz()
        self._noise = pink_noise(level_db=level_db, seed=seed, sample_rate_hz=self._rate_hz)
        self._stream: Any = None
        self._playback: Playback

    @property
    def state(self) -> NoiseState:
        """State of the noise: "playing" or "silent"."""
        return "silent" if self._stream is None else "playing"

    def start(self) -> None:
        """Fade the noise in unless it is playing, and wait until it reaches its level.

        The plate may vibrate only afterwards, because noise that is still fading in does not mask
        the plate's sound.

        Raises
        ------
        RigError
            If the sound output is missing or does not play.
        """
        if self._stream is not None:
            return
        wrong = check_device()
        if wrong:
            raise RigError("masking noise: {wrong}", wrong=wrong)
        import sounddevice

        playback = Playback(self._noise, round(self._fade_s * self._rate_hz))
        playback.target = 1.0

        def fill(memory: Any, *_about: Any) -> None:
            playback.fill(np.frombuffer(memory, np.float32).reshape(-1, CHANNELS))

        try:
            # A raw stream is used, because NumPy 2.5 warns each time sounddevice creates its own
            # arrays.
            stream = sounddevice.RawOutputStream(
                samplerate=self._rate_hz, channels=CHANNELS, dtype="float32", callback=fill
            )
            stream.start()
        except sounddevice.PortAudioError as error:
            raise RigError("masking noise: {error}: {remedy}", error=error, remedy=REMEDY) from None
        self._playback, self._stream = playback, stream
        if not playback.level.wait(self._fade_s + STALL_S):
            self.stop()
            raise RigError("masking noise: the sound device does not play; {remedy}", remedy=REMEDY)

    def stop(self) -> None:
        """Fade the noise out and release the device; do nothing if no noise is playing."""
        if self._stream is None:
            return
        self._playback.silent.clear()
        self._playback.target = 0.0
        self._playback.silent.wait(self._fade_s + STALL_S)
        stream, self._stream = self._stream, None
        stream.close()
