"""Presentations a second on the mock plate, beside integrating the same plate's equation.

    python benchmarks/mock_presentations.py [PRESENTATIONS]

The twin steps the envelope in closed form. The usual way to simulate it is to integrate the same
envelope with SciPy's solve_ivp at its default accuracy (1e-3; the twin's is exact).
"""

from __future__ import annotations

import math
import sys
import time

from scipy.integrate import solve_ivp

from slipscale.hardware.backends.mock import RAMP_S
from slipscale.hardware.clock import VirtualClock
from slipscale.hardware.plate.dynamics import Resonator, conditions
from slipscale.hardware.plate.twin import SETTLING_TIME_CONSTANTS
from slipscale.hardware.registry import open_plate
from slipscale.stimuli.surface import VirtualSurface

PRESENTATIONS = 5_000
INTEGRATED = 100
AMPLITUDES_UM_PP = (0.0, 0.5, 1.2, 2.3)
GOAL = 1_000


def mock_rate(count: int) -> float:
    """Return presentations a second through the whole driver: limits, ramp, readback, log."""
    plate = open_plate("mock", clock=VirtualClock(), seed=1)
    plate.connect()
    surfaces = [VirtualSurface(amplitude_um_pp=each) for each in AMPLITUDES_UM_PP]
    begun = time.perf_counter()
    for i in range(count):
        plate.present(surfaces[i % len(surfaces)])
    return count / (time.perf_counter() - begun)


def integrated_rate(count: int) -> float:
    """Return presentations a second of the bare equation, integrated."""
    plate = conditions(Resonator())
    rate = 1 / plate.time_constant_s
    duration_s = RAMP_S + SETTLING_TIME_CONSTANTS * plate.time_constant_s
    state = [0.0, 0.0]
    begun = time.perf_counter()
    for i in range(count):
        start = state[0]
        end = AMPLITUDES_UM_PP[i % len(AMPLITUDES_UM_PP)]

        def envelope(
            t: float, a: list[float], start: float = start, end: float = end
        ) -> list[float]:
            target = start + (end - start) * (0.5 - 0.5 * math.cos(math.pi * min(t / RAMP_S, 1)))
            return [-rate * (a[0] - target), -rate * a[1]]

        state = solve_ivp(envelope, (0, duration_s), state).y[:, -1].tolist()
    return count / (time.perf_counter() - begun)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else PRESENTATIONS
    ours, integrated = mock_rate(count), integrated_rate(INTEGRATED)
    print(f"mock plate, whole driver     {ours:>8.0f} presentations/s   (goal: {GOAL})")
    print(f"solve_ivp, equation alone    {integrated:>8.0f} presentations/s")
    print(f"ratio                        {ours / integrated:>8.1f}")


if __name__ == "__main__":
    main()
