"""Simulate sensors for the position and forces of a simulated participant's finger.

SPEC for positions: ``simulated`` or ``simulated:rate=100,noise=0.02`` (samples per second; standard
deviation of a reading in mm). SPEC for forces: ``simulated`` or ``simulated:friction=0.8,...`` with

==============  ==================================================================
``friction``    coefficient of friction on the plate at rest (0.8: our assumption)
``film``        ``reynolds`` (2007), or ``shared_load``: each simulated participant has individual
                skin within the ranges of `slipscale.stimuli.film.shared_load` (not validated)
``roughness``   average roughness h_r of the film ``reynolds``, µm (0.6, Section IV-A)
``rate``        samples per second (100)
``noise``       standard deviation of a reading of either force, N (0.005)
==============  ==================================================================

The squeeze film carries part of the finger's load, and the rest of the load causes friction. If the
model predicts levitation, there is no friction.

Readings depend on the seed, the finger and the time, but not on earlier readings. A pilot that was
interrupted and resumed therefore yields the same readings as an uninterrupted pilot.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from functools import cache
from typing import ClassVar

from slipscale.faults import UserError
from slipscale.faults.message import Message
from slipscale.hardware import address as addresses
from slipscale.hardware.contact.source import (
    FORCE,
    POSITION,
    ContactSource,
    Quantities,
    Sample,
    Surroundings,
    Touch,
)
from slipscale.stimuli.surface import VirtualSurface, peak_from_pp

RATE_HZ = 100.0
POSITION_NOISE_MM, FORCE_NOISE_N = 0.02, 0.005
FRICTION, ROUGHNESS_UM = 0.8, 0.6
# Amplitudes in µm and forces in N are rounded to this number of decimals, because each solution of
# the film equations takes 50 ms and is cached.
AMPLITUDE_DIGITS = 1
FORCE_DIGITS = 1
WORD = (1 << 64) - 1

POSITION_OPTIONS: dict[str, Callable[[str], object]] = {
    "rate": addresses.positive_number,
    "noise": addresses.number_from_0,
}


def _film(text: str) -> str:
    if text not in FILMS:
        raise ValueError(Message("expected {films}", films=" or ".join(FILMS)))
    return text


FORCE_OPTIONS: dict[str, Callable[[str], object]] = {
    **POSITION_OPTIONS,
    "film": _film,
    "friction": addresses.positive_number,
    "roughness": addresses.positive_number,
}


class _Simulated(ContactSource):
    """Simulated sensor with noise on a regular time grid."""

    name: ClassVar[str] = "simulated"
    virtual = True

    def __init__(self, surroundings: Surroundings, *, rate_hz: float, noise: float) -> None:
        finger = surroundings.finger
        if finger is None or finger.unit != "mm":
            raise UserError(
                "simulated position and force are only for simulated participants; for a "
                "person, use sensors (see docs/how-to/finger.md)"
            )
        self._finger = finger
        self._surroundings = surroundings
        self._rate_hz = rate_hz
        self._noise = noise
        self._begun_s = surroundings.clock.now()
        self._taken = 0

    def connect(self) -> None:
        """Do nothing."""

    def begin(self) -> None:
        """Start a new series of samples at the current time."""
        self._begun_s, self._taken = self._surroundings.clock.now(), 0

    def take(self) -> list[Sample]:
        """Return the readings taken since the last call while the finger touched the plate."""
        now_s = self._surroundings.clock.now()
        until = math.floor((now_s - self._begun_s) * self._rate_hz + 1e-6)
        found = []
        for number in range(self._taken, until + 1):
            time_s = self._begun_s + number / self._rate_hz
            touch = self._finger.at(time_s)
            if touch is not None:
                noise = self._deviates(number)
                exact = self._exact(time_s, touch)
                values = [v + self._noise * n for v, n in zip(exact, noise, strict=True)]
                found.append(Sample(time_s, tuple(values)))
        self._taken = max(until + 1, self._taken)
        return found

    def _exact(self, time_s: float, touch: Touch) -> tuple[float, float]:
        """Return a reading without noise."""
        raise NotImplementedError

    def _deviates(self, number: int) -> tuple[float, float]:
        """Draw the two standard normal deviates for a reading's noise."""
        import numpy as np

        milliseconds = round(self._begun_s * 1000)
        key = np.array([self._surroundings.seed & WORD, milliseconds & WORD], dtype=np.uint64)
        counter = np.array([number, int(self.quantities == FORCE), 0, 0], dtype=np.uint64)
        both = np.random.Generator(np.random.Philox(key=key, counter=counter)).normal(size=2)
        return float(both[0]), float(both[1])

    def close(self) -> None:
        """Do nothing."""

    def describe(self) -> dict[str, object]:
        """Return the source's name, sampling rate and noise."""
        return {"name": self.name, "rate_hz": self._rate_hz, "noise": self._noise}


class SimulatedPosition(_Simulated):
    """Position of the simulated finger; for options, see the module's documentation."""

    quantities: Quantities = POSITION

    def _exact(self, time_s: float, touch: Touch) -> tuple[float, float]:  # noqa: ARG002 - no film
        return touch.x, touch.y


class SimulatedForce(_Simulated):
    """Simulated forces of the finger; for options, see the module's documentation.

    The film is computed for the amplitude at the time of the call, so call `take` frequently while
    the amplitude changes.
    """

    quantities: Quantities = FORCE

    def __init__(
        self,
        surroundings: Surroundings,
        *,
        rate_hz: float = RATE_HZ,
        noise: float = FORCE_NOISE_N,
        friction: float = FRICTION,
        roughness_um: float = ROUGHNESS_UM,
        film: str = "reynolds",
    ) -> None:
        super().__init__(surroundings, rate_hz=rate_hz, noise=noise)
        if surroundings.vibration_level is None:
            raise UserError("--force simulated: simulated forces are only available in pilots")
        self._vibration_um_pp = surroundings.vibration_level
        self._friction = friction
        self._film = film
        # The Reynolds model requires the roughness; the shared-load model requires a value from 0
        # to 1 that selects the skin properties.
        self._surface = roughness_um if film == "reynolds" else _place_in_band(surroundings)

    def _exact(self, time_s: float, touch: Touch) -> tuple[float, float]:
        before = self._finger.at(time_s - 0.5 / self._rate_hz)
        moved = touch.x - before.x if before else 0.0
        amplitude_um_pp = round(self._vibration_um_pp(), AMPLITUDE_DIGITS)
        carried_n = FILMS[self._film](amplitude_um_pp, self._surface, touch.normal_n)
        lateral = self._friction * max(touch.normal_n - carried_n, 0.0)
        return touch.normal_n, math.copysign(lateral, moved) if moved else 0.0

    def describe(self) -> dict[str, object]:
        """Return the source's name, sampling rate, noise and assumptions about the film."""
        return {
            **super().describe(),
            "friction_at_rest": self._friction,
            "roughness_um" if self._film == "reynolds" else "place_in_band": self._surface,
            "film": self._film,
        }


@cache
def _film_force_n(amplitude_um_pp: float, roughness_um: float) -> float:
    """Return the force that the film carries in the Reynolds model, in N."""
    if amplitude_um_pp == 0:
        return 0.0
    relative = VirtualSurface(level=amplitude_um_pp).predicted_relative_friction(
        roughness_um=roughness_um, normal_force_n=1.0
    )
    return 1.0 - relative


def _shared_force_n(amplitude_um_pp: float, place: float, normal_n: float) -> float:
    """Return the part of the normal force that the film carries in the shared-load model."""
    from slipscale.stimuli.film.shared_load import skin_between, solve

    force_n = max(round(normal_n, FORCE_DIGITS), 10.0**-FORCE_DIGITS)
    skin = skin_between(place)
    return normal_n * solve(skin, peak_from_pp(amplitude_um_pp), normal_force_n=force_n).film_share


FILMS: dict[str, Callable[[float, float, float], float]] = {
    "reynolds": lambda amplitude_um_pp, roughness_um, _: _film_force_n(
        amplitude_um_pp, roughness_um
    ),
    "shared_load": _shared_force_n,
}


def _place_in_band(surroundings: Surroundings) -> float:
    """Return a simulated participant's position in the range of skin properties, from 0 to 1."""
    import numpy as np

    person = zlib.crc32(surroundings.participant.encode())
    return float(np.random.default_rng([surroundings.seed & WORD, person]).random())


def open_position(address: str, surroundings: Surroundings) -> ContactSource:
    """Return the simulated position sensor (entry point ``simulated``). Raises `UserError`."""
    _, options = addresses.split_address(address, POSITION_OPTIONS, what="--position simulated")
    return SimulatedPosition(
        surroundings,
        rate_hz=options.get("rate", RATE_HZ),
        noise=options.get("noise", POSITION_NOISE_MM),
    )


def open_force(address: str, surroundings: Surroundings) -> ContactSource:
    """Return the simulated force sensor (entry point ``simulated``). Raises `UserError`."""
    _, options = addresses.split_address(address, FORCE_OPTIONS, what="--force simulated")
    return SimulatedForce(
        surroundings,
        rate_hz=options.get("rate", RATE_HZ),
        noise=options.get("noise", FORCE_NOISE_N),
        friction=options.get("friction", FRICTION),
        roughness_um=options.get("roughness", ROUGHNESS_UM),
        film=options.get("film", "reynolds"),
    )
