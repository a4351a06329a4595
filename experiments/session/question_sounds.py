"""Sounds that accompany a question: interface and player.

A session starts and stops `Sounds`. Only `SoundOutput` opens the sound device, when it starts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from slipscale.experiments.session.masking_noise import CHANNELS, REMEDY, device_rate_hz
from slipscale.faults import RigError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from slipscale.stimuli.headphone_sounds import HeadphoneSound


class Sounds(Protocol):
    """Plays sounds through the headphones."""

    @property
    def missing(self) -> str:
        """Why nothing can be heard; empty if sound can be played."""

    def start(self, sound: HeadphoneSound) -> None:
        """Start playing a sound, after stopping any that is playing."""

    def stop(self) -> None:
        """Stop the sound that is playing."""


class NoSounds:
    """A stand-in for a missing sound output."""

    def __init__(self, missing: str) -> None:
        self.missing = missing

    def start(self, sound: HeadphoneSound) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""


class ImaginedSounds(NoSounds):
    """Sounds for simulated participants, who receive the samples directly."""

    def __init__(self) -> None:
        super().__init__("")


class Once:
    """Supplies samples once, then silence, to the sound card thread."""

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
    """The system's sound output; use `masking_noise.check_device` to check that there is one."""

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
        import sounddevice  # noqa: PLC0415  cannot be imported without PortAudio

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
            raise RigError(f"headphone test: {error}: {REMEDY}") from None
        self._stream = stream

    def stop(self) -> None:
        """Stop the sound that is playing, and release the device."""
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.close()
