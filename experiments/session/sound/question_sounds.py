"""Play sounds that accompany questions, as in the headphone test.

A session starts and stops sounds with the methods of `Sounds`. The sound device is opened only by
`SoundOutput`, and only when a sound starts.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from slipscale.experiments.session.sound.masking_noise import CHANNELS, REMEDY, device_rate_hz
from slipscale.faults import RigError
from slipscale.stimuli.headphone_sounds import HeadphoneSound


class Sounds(Protocol):
    """Common interface for playing sounds in the headphones."""

    @property
    def missing(self) -> str:
        """Reason why no sounds can be played; empty if they can."""

    def start(self, sound: HeadphoneSound) -> None:
        """Stop any sound that is playing, then start a new one."""

    def stop(self) -> None:
        """Stop the sound that is playing."""


class NoSounds:
    """Replaces the sound output in sessions that cannot play sounds."""

    def __init__(self, missing: str) -> None:
        self.missing = missing

    def start(self, sound: HeadphoneSound) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""


class ImaginedSounds(NoSounds):
    """Replaces the sound output for simulated participants, who need no sound card."""

    def __init__(self) -> None:
        super().__init__("")


class Once:
    """Samples that the sound card's thread plays once, followed by silence."""

    def __init__(self, samples: NDArray[np.float32]) -> None:
        self._samples = samples
        self._position = 0

    def fill(self, block: NDArray[np.float32]) -> None:
        """Write the next samples into ``block``, shape (samples, channels)."""
        part = self._samples[self._position : self._position + len(block)]
        block[: len(part)] = part
        block[len(part) :] = 0.0
        self._position += len(part)


class SoundOutput:
    """The system's sound output. To check that it works, use `masking_noise.check_device`."""

    missing = ""

    def __init__(self) -> None:
        self._stream: Any = None

    def start(self, sound: HeadphoneSound) -> None:
        """Start playing a sound.

        Raises
        ------
        RigError
            If the device does not play.
        """
        self.stop()
        import sounddevice

        rate_hz = device_rate_hz()
        playing = Once(sound.samples(rate_hz))

        def fill(memory: Any, *_about: Any) -> None:
            playing.fill(np.frombuffer(memory, np.float32).reshape(-1, CHANNELS))

        try:
            stream = sounddevice.RawOutputStream(
                samplerate=rate_hz, channels=CHANNELS, dtype="float32", callback=fill
            )
            stream.start()
        except sounddevice.PortAudioError as error:
            raise RigError(
                "headphone test: {error}: {remedy}", error=error, remedy=REMEDY
            ) from None
        self._stream = stream

    def stop(self) -> None:
        """Stop the sound that is playing, and release the device."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()
