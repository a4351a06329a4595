"""How late a texture is under a finger that is followed, on a driver board and on the mock plate.

    python benchmarks/texture_latency.py [--seconds 20]

A finger goes over a sine grating of 10 mm at constant speed. Its place is told 60 times a second,
as a window's frames do, and the session's own code follows it. What the simulated plate truly does
is compared with what the grating says at the finger's true place: the lag is the one that brings
both together best, the error that remains is told in parts of the depth (60 steps a second leave
some).
The emulated board and the compiled firmware are reached over a pseudo-terminal, in real time; a
real port adds some 5 ms at 115,200 baud. "no prediction" is the lag that the plate and its line
have, where the host looks ahead by half a frame only.
"""

from __future__ import annotations

import argparse
import math
import time
from typing import TYPE_CHECKING

import numpy as np

from slipscale.hardware.clock import SystemClock, VirtualClock
from slipscale.hardware.contact.followed_texture import FollowedTexture
from slipscale.hardware.contact.source import Sample
from slipscale.hardware.emulator.process import EmulatorProcess
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.texture import Grating

if TYPE_CHECKING:
    from collections.abc import Callable

FRAME_S = 1 / 60
LOOKS = 4  # of the true amplitude in a frame
LAGS_S = np.arange(-0.02, 0.06, 0.0005)
SETTLED_S = 0.3


def grating(period_mm: float) -> Grating:
    return Grating(spatial_period_mm=period_mm, mean_um_pp=1.2, depth_um_pp=0.8)


def lag_of(
    wave: Grating, speed_mm_s: float, seen: list[tuple[float, float]]
) -> tuple[float, float]:
    """Return lag in s and the RMS error that remains, in parts of the depth."""
    times = np.array([t for t, _ in seen if t > SETTLED_S])
    true = np.array([a for t, a in seen if t > SETTLED_S])
    errors = [
        math.sqrt(
            np.mean(
                [
                    (a - wave.amplitude_at_um_pp(speed_mm_s * (t - lag))) ** 2
                    for t, a in zip(times, true, strict=True)
                ]
            )
        )
        for lag in LAGS_S
    ]
    best = int(np.argmin(errors))
    return float(LAGS_S[best]), errors[best] / wave.depth_um_pp


def mock(
    wave: Grating, speed_mm_s: float, seconds: float, *, predicts: bool
) -> tuple[float, float]:
    clock = VirtualClock()
    with open_plate("mock", clock=clock) as plate:
        follower = FollowedTexture(wave, (plate.follow_lag_s or 0.0) if predicts else 0.0)
        plate.present(follower.mean)
        begun_s = clock.now()
        seen = []
        while clock.now() - begun_s < seconds:
            now_s = clock.now()
            follower.see([Sample(now_s, (speed_mm_s * (now_s - begun_s), 0.0))])
            plate.follow(follower.amplitude_um_pp(now_s))
            for _ in range(LOOKS):
                clock.sleep(FRAME_S / LOOKS)
                seen.append((clock.now() - begun_s, plate.vibration_um_pp()))
    return lag_of(wave, speed_mm_s, seen)


def board(
    wave: Grating, speed_mm_s: float, seconds: float, *more: str, predicts: bool
) -> tuple[float, float]:
    with EmulatorProcess("--noise", "0", *more) as emulated:
        clock = SystemClock()
        with open_plate(f"serial:{emulated.port}", clock=clock) as plate:
            follower = FollowedTexture(wave, (plate.follow_lag_s or 0.0) if predicts else 0.0)
            plate.present(follower.mean)
            begun_s = clock.now()
            seen = []
            frame = 0
            while clock.now() - begun_s < seconds:
                now_s = clock.now()
                follower.see([Sample(now_s, (speed_mm_s * (now_s - begun_s), 0.0))])
                plate.follow(follower.amplitude_um_pp(now_s))
                plate.check()
                frame += 1
                while (left_s := begun_s + frame * FRAME_S - clock.now()) > FRAME_S / 10:
                    seen.append((clock.now() - begun_s, float(emulated.state()["amplitude_um_pp"])))
                    time.sleep(min(FRAME_S / LOOKS, max(left_s - 0.001, 0.0)))
    return lag_of(wave, speed_mm_s, seen)


def firmware(
    wave: Grating, speed_mm_s: float, seconds: float, *, predicts: bool
) -> tuple[float, float]:
    return board(wave, speed_mm_s, seconds, "--firmware", predicts=predicts)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=20.0)
    seconds = parser.parse_args().seconds
    plates: dict[str, Callable[..., tuple[float, float]]] = {
        "mock": mock,
        "emulated board": board,
        "compiled firmware": firmware,
    }
    print(f"{'plate':<19}{'periods/s':>10}{'lag, ms':>9}{'left':>7}{'no prediction, ms':>19}")
    for name, run in plates.items():
        for rate_hz in (2.0, 5.0, 10.0):
            wave, speed_mm_s = grating(10.0), 10.0 * rate_hz
            lag_s, left = run(wave, speed_mm_s, seconds, predicts=True)
            raw_s, _ = run(wave, speed_mm_s, seconds, predicts=False)
            print(
                f"{name:<19}{rate_hz:>10.0f}{1000 * lag_s:>9.1f}{left:>7.0%}{1000 * raw_s:>19.1f}"
            )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
