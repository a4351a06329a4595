"""How long a plate goes on vibrating after its session's process ends, in each way it can.

    python benchmarks/silence_latency.py [TIMES]

Measured at the wire: a host process drives a pseudo-terminal whose other end, here, stamps the
arrival of the stop byte. After SIGKILL nothing comes, and what counts is the emulated board's
watchdog: the line is one that does not tell the board that the host is gone.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
import tty
from statistics import median

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.emulator.firmware import Board
from slipscale.hardware.plate.twin import Twin

TIMES = 20
GOAL_MS = 50
GIVE_UP_S = 2.0

HOST = """
import sys, time
from slipscale.hardware.clock import SystemClock
from slipscale.hardware.registry import open_plate
from slipscale.hardware.signals import silent_on_signals
from slipscale.stimuli.surface import VirtualSurface

plate = open_plate("serial:" + sys.argv[1], clock=SystemClock())
with silent_on_signals(plate):
    plate.connect()
    plate.present(VirtualSurface(amplitude_um_pp=2.3))
    print("presented", flush=True)
    if sys.argv[2] == "exception":
        sys.stdin.read(1)
        raise ValueError
    while True:
        time.sleep(0.001)
        plate.check()
"""


class Wire:
    """The board's end: an emulated board in this process, and when its output went off."""

    def __init__(self) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.board = Board(Twin(), boot=1)

    def turn(self) -> float | None:
        """Serve the line for a moment; return the time if the plate is silent now."""
        ready, _, _ = select.select([self.master], [], [], 0.0005)
        now = time.perf_counter()
        data = os.read(self.master, 4096) if ready else b""
        for _, reply in self.board.receive(data, now):
            os.write(self.master, reply)
        self.board.tick(now)
        return None if self.board.vibrates else now

    def close(self) -> None:
        """Let go of the line."""
        os.close(self.slave)
        os.close(self.master)


def once(way: str) -> float:
    """Return the milliseconds from the end's cause to silence."""
    line = Wire()
    host = subprocess.Popen(
        [sys.executable, "-c", HOST, os.ttyname(line.slave), way],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        while not select.select([host.stdout], [], [], 0)[0]:
            line.turn()
        host.stdout.readline()
        settled = time.perf_counter() + 0.2
        while time.perf_counter() < settled:
            line.turn()
        begun = time.perf_counter()
        if way == "exception":
            host.stdin.write(b"x")
            host.stdin.flush()
        else:
            host.send_signal(getattr(signal, way))
        silent = None
        while silent is None and time.perf_counter() < begun + GIVE_UP_S:
            silent = line.turn()
        if silent is None:
            raise SystemExit(f"{way}: the plate still vibrates after {GIVE_UP_S} s")
        ended = time.perf_counter()
        while host.poll() is None and time.perf_counter() < ended + GIVE_UP_S:
            line.turn()
        return (silent - begun) * 1e3
    finally:
        host.kill()
        host.wait()
        line.close()


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else TIMES
    print(f"{count} times each, ms to silence   median      max     goal")
    watchdog_ms = wire.BoardLimits().watchdog_ms
    for way in ("exception", "SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"):
        times = [once(way) for _ in range(count)]
        goal = watchdog_ms + 2 if way == "SIGKILL" else GOAL_MS  # a tick of the board after it
        print(f"{way:<30}{median(times):>8.1f} {max(times):>8.1f} {goal:>8.0f}")


if __name__ == "__main__":
    main()
