"""Simulate a rig for every backend, with the plate's true amplitude and possible events."""

from __future__ import annotations

import datetime as dt
import math
import random
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from functools import cache, partial
from typing import TYPE_CHECKING, Any
from unittest import mock

import numpy as np

from slipscale.hardware.address import Plate
from slipscale.hardware.backends.daq_device import TERMINALS
from slipscale.hardware.backends.daq_output import DaqOutput
from slipscale.hardware.backends.function_generator import FunctionGenerator
from slipscale.hardware.backends.mock import MockPlate
from slipscale.hardware.backends.pair import PlatePair
from slipscale.hardware.backends.serial_board.driver import SerialBoard
from slipscale.hardware.backends.sound_card.driver import SoundCard
from slipscale.hardware.calibration.record import Calibration, Device, DriveChain, Provenance
from slipscale.hardware.calibration.sweep import SweepPlan, calibration_from, sweep
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.emulator.generators import MAKES
from slipscale.hardware.errors import ConnectionLost
from slipscale.hardware.plate.dynamics import NO_FINGER, FingerLoad
from slipscale.hardware.plate.twin import Twin
from slipscale.hardware.records import Output
from tests.support.local_line import LocalLine
from tools.campaigns.wrong_boards.virtual_line import VirtualLine

if TYPE_CHECKING:
    from slipscale.hardware.driver import PlateDriver
    from slipscale.stimuli.modulation import Loop
    from slipscale.stimuli.surface import Sensor, Surface


HISTORIES, EVENTS = 10_000, 12
GAIN_UM_PER_V, RESONANCE_HZ, QUALITY = 2.3 / 15, 30_500.0, 60.0
AMPLIFIER, FULL_SCALE_V, LEVEL_PER_V = 10.0, 20.0, 0.3
RATE_HZ, BLOCK = 192_000.0, 4096


def _ideal(frequency_hz: float, voltage_v: float) -> float:
    detuning = 2 * QUALITY * (frequency_hz - RESONANCE_HZ) / RESONANCE_HZ
    return GAIN_UM_PER_V * voltage_v / math.hypot(1, detuning)


@cache
def calibration(backend: str, serial: str, gain: float) -> Calibration:
    """Return the calibration of an ideal plate behind a device."""
    return calibration_from(
        sweep(SweepPlan(), _ideal),
        device=Device(backend=backend, serial=serial),
        made=Provenance(date=dt.datetime.now(tz=dt.UTC).date(), by="a campaign", instrument="none"),
        drive=DriveChain(amplifier_gain=gain),
    )


class Rig(ABC):
    """Simulated rig: a plate, the amplitude of its drive, and possible events such as faults."""

    plate: PlateDriver
    happenings: dict[str, Callable[[], object]]
    modules: dict[str, Any] = {}  # noqa: RUF012 - none but a sound card's

    @abstractmethod
    def true_um_pp(self) -> float:
        """Return the amplitude that the active drive produces."""


class MockRig(Rig):
    """The mock with its injected faults."""

    def __init__(self) -> None:
        self.twin = Twin(noise_um=0)
        self.plate = MockPlate(clock=VirtualClock(), twin=self.twin)
        self.happenings = {
            f"{code} at {phase}": partial(self._order, code, phase)
            for code in ("lost", "time_out", "garbled", "still_vibrating")
            for phase in ("present", "read_back", "silence", "connect")
        }

    def _order(self, code: str, phase: str) -> None:
        if isinstance(self.plate, MockPlate):
            self.plate.inject(code, phase=phase)

    def true_um_pp(self) -> float:
        """Return the simulated plate's true amplitude."""
        return self.plate.vibration_level() if self.twin.drive.target_um_pp else 0.0


class GeneratorRig(Rig):
    """A generator of one make, its front panel and its line."""

    def __init__(self, make: str) -> None:
        self.line = LocalLine(MAKES[make]())
        self.generator = self.line.generator
        serial = self.generator.identity.split(",")[2]
        plate = FunctionGenerator(
            self.line,
            clock=VirtualClock(),
            plate=Plate(calibration=calibration("scpi", serial, AMPLIFIER)),
        )
        plate._machine = VirtualClock()  # noqa: SLF001 - nothing waits
        self.plate = plate
        functions: Any = getattr(self.generator, "functions", ())
        names = functions.values() if isinstance(functions, dict) else functions
        keys = [each for each in names if each not in {"BPSK", "SUM"} or make == "rigol"]
        self.happenings = {
            "preset": self.generator.reset,
            "load 50 Ω": lambda: setattr(self._channel, "load_ohm", 50.0),
            "square": lambda: setattr(self._channel, "function", "SQU"),
            "frequency": lambda: setattr(self._channel, "frequency_hz", 29_000.0),
            "amplitude": lambda: self._channel.set_open_vpp(0.7),
            "output key": lambda: setattr(self._channel, "on", False),
            "line drops": lambda: self._drop(for_good=False),
            "line is gone": lambda: self._drop(for_good=True),
            "line is back": lambda: setattr(self.line, "drop_at", None),
            **{key: partial(self._modulate, key) for key in keys},
        }

    @property
    def _channel(self) -> Any:
        return self.generator.channel[1]

    def _modulate(self, function: str) -> None:
        self._channel.active = {function}

    def _drop(self, *, for_good: bool) -> None:
        self.line.drop_at = len(self.line.wire) + random.Random(len(self.line.wire)).randint(1, 60)
        self.line.for_good = for_good

    def true_um_pp(self) -> float:
        """Return the simulated plate's true amplitude."""
        return _ideal(self._channel.frequency_hz, self._channel.plate_vpp() * AMPLIFIER / 2)


class Plug(VirtualLine):
    """A line that also powers its board and can be unplugged."""

    down = False

    def write(self, data: bytes) -> None:
        """Send bytes to the board."""
        if self.down:
            raise ConnectionLost("virtual: the device went away")
        super().write(data)

    def read(self) -> bytes:
        """Return what the board has sent."""
        if self.down:
            raise ConnectionLost("virtual: the device went away")
        return super().read()


class BoardRig(Rig):
    """Rig with an emulated board, a sensor, a plug that can be pulled, and a finger."""

    def __init__(self) -> None:
        self.twin = Twin(noise_um=0.002)
        self.line = Plug(Board(self.twin, boot=1))
        serial = self.line.board.identity.split(",")[2]
        self.plate = SerialBoard(
            self.line.port,
            clock=self.line,
            plate=Plate(calibration=calibration("serial", serial, 1.0)),
            host=self.line,
        )
        self.happenings = {
            "unplugged": self._unplug,
            "plugged in": lambda: setattr(self.line, "down", False),
            "restarts": self._restart,
            "sensor reads half": lambda: setattr(self.twin, "sensor", 0.5),
            "sensor is dead": lambda: setattr(self.twin, "sensor", 0.0),
            "sensor is right": lambda: setattr(self.twin, "sensor", 1.0),
            "finger": lambda: self._touch(FingerLoad(loss=1 / 300)),
            "no finger": lambda: self._touch(NO_FINGER),
            "hot": lambda: setattr(self.line.board, "hot", True),
            "cool": lambda: setattr(self.line.board, "hot", False),
            "hang": lambda: self.line.sleep(0.7),
        }

    def _unplug(self) -> None:
        self.line.down = True
        self._restart()

    def _restart(self) -> None:
        self.line.board.silence(self.line.now())
        self.line.board = Board(self.twin, boot=random.Random(self.line.now()).randint(2, 10**6))

    def _touch(self, finger: FingerLoad) -> None:
        self.twin.amplitude_um_pp(self.line.now())
        self.twin.finger = finger

    def true_um_pp(self) -> float:
        """Return the simulated plate's true amplitude."""
        if not self.line.board.vibrates:
            return 0.0
        return self.twin.amplitude_um_pp(self.line.now())


class Audio:
    """A stand-in for the module sounddevice: a card that plays while the clock sleeps."""

    PortAudioError = OSError
    latency = 0.01

    def __init__(self) -> None:
        self.active = self.stuck = self.underflow = False
        self.callback: Callable[..., None] | None = None
        self.level = 0.0

    def query_devices(self, *_: object, **__: object) -> dict[str, str]:
        """Return the card's name."""
        return {"name": "card"}

    def RawOutputStream(self, **options: Any) -> Audio:  # noqa: N802 - sounddevice's name
        """Open the card."""
        self.callback = options["callback"]
        return self

    def start(self) -> None:
        """Start playing."""
        self.active, self.stuck, self.underflow = True, False, False

    def abort(self) -> None:
        """Stop immediately."""
        self.active, self.level = False, 0.0

    def close(self, **_: object) -> None:
        """Close the card."""
        self.abort()

    def play(self, duration_s: float) -> None:
        """Request ``duration_s`` of samples from the driver."""
        if not self.active or self.stuck or self.callback is None:
            return
        for _ in range(max(round(duration_s * RATE_HZ / BLOCK), 1)):
            block: Any = np.zeros((BLOCK, 2), np.float32)
            status = mock.Mock(output_underflow=self.underflow)
            self.callback(memoryview(block.reshape(-1)), BLOCK, None, status)
            self.level = float(np.abs(block[-256:]).max())


class AudioClock(VirtualClock):
    """Virtual clock that lets the sound card play during waits."""

    def __init__(self, audio: Audio) -> None:
        super().__init__()
        self.audio = audio

    def sleep(self, duration_s: float) -> None:
        """Advance the clock, and let the card play."""
        super().sleep(duration_s)
        self.audio.play(duration_s)


class SoundRig(Rig):
    """A sound card that can vanish, hang or be too slow."""

    def __init__(self) -> None:
        self.audio = Audio()
        self.modules = {"sounddevice": self.audio}
        plate = SoundCard(
            "3",
            clock=VirtualClock(),
            plate=Plate(calibration=calibration("sound", "card, channel 1", 20.0)),
        )
        plate._machine = AudioClock(self.audio)  # noqa: SLF001 - nothing waits
        self.plate = plate
        self.happenings = {
            "vanishes": self.audio.abort,
            "hangs": lambda: setattr(self.audio, "stuck", True),
            "is too slow": lambda: setattr(self.audio, "underflow", True),
        }

    def true_um_pp(self) -> float:
        """Return the simulated plate's true amplitude."""
        return GAIN_UM_PER_V * FULL_SCALE_V * self.audio.level if self.audio.active else 0.0


class DaqRig(Rig):
    """An analogue output that can lose its connection, its exclusive access or its readback."""

    def __init__(self) -> None:
        TERMINALS.__init__()  # type: ignore[misc]  # the module has one device
        self.plate = DaqOutput(
            "emulated/ao0",
            {"frequency": RESONANCE_HZ, "per_volt": LEVEL_PER_V, "readback": "emulated/ai0"},
            clock=VirtualClock(),
            plate=Plate(),
        )
        self.happenings = {
            "unplugged": partial(self._set, unplugged=True),
            "plugged in": partial(self._set, unplugged=False),
            "loses power": partial(self._set, unplugged=True, output_v=[0.0]),
            "input falls off": partial(self._set, wired=False),
            "input is wired": partial(self._set, wired=True),
            "taken by another program": partial(self._set, reserved=True),
            "released by it": self._release,
        }

    def _set(self, **changes: object) -> None:
        for name, value in changes.items():
            setattr(TERMINALS, name, value)

    def _release(self) -> None:
        if self.plate.output is not Output.MAY_BE_ON:
            TERMINALS.reserved = False

    def true_um_pp(self) -> float:
        """Return the level that the voltage at the terminal produces."""
        return LEVEL_PER_V * max(map(abs, TERMINALS.output_v))


class Alike(PlatePair):
    """Pair in which both actuators have the same level, so that they can be compared."""

    def check_supported(self, surface: Surface, *, sensors: Collection[Sensor] = ()) -> Loop | None:
        """Set the level of the second actuator, then check both actuators."""
        self.second_level = surface.level
        return super().check_supported(surface, sensors=sensors)


class PairRig(Rig):
    """An emulated board and a mock as two actuators, with the faults of both."""

    def __init__(self) -> None:
        self.rigs = (BoardRig(), MockRig())
        self.plate = Alike(*(each.plate for each in self.rigs))
        self.happenings = {
            f"{number}: {name}": happening
            for number, rig in enumerate(self.rigs, start=1)
            for name, happening in rig.happenings.items()
        }

    def true_um_pp(self) -> float:
        """Return the amplitude of the actuators or, if their amplitudes differ, the sum."""
        both = [rig.true_um_pp() for rig in self.rigs]
        alike = max(both) - min(both) <= self.plate.limits.allowed_level(max(both))
        return max(both) if alike else sum(both)


RIGS: dict[str, Callable[[], Rig]] = {
    "mock": MockRig,
    "pair": PairRig,
    "serial": BoardRig,
    "sound": SoundRig,
    "daq": DaqRig,
    **{f"scpi {make}": partial(GeneratorRig, make) for make in MAKES},
}
