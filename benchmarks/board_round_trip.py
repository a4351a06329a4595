"""A command to the driver board, beside pyserial's bare write and readline of the same bytes.

    python benchmarks/board_round_trip.py [ROUND_TRIPS]

Both talk to the same answering process over a pseudo-terminal; rounds of each alternate, so that
the machine's moods hit both. What ours adds: sequence number, checksum, time-out, repetition, a
lock. What bare pyserial lacks besides: a late answer puts it off by one for good.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
import tty
from statistics import quantiles
from typing import TYPE_CHECKING

import serial

from slipscale.hardware.backends.serial_board import protocol as wire
from slipscale.hardware.backends.serial_board.link import BoardLink
from slipscale.hardware.backends.serial_board.serial_line import SerialLine

if TYPE_CHECKING:
    from collections.abc import Callable

ROUND_TRIPS = 10_000
BATCH = 500
STATUS = "HOLD,2.3000,2.2987,30499.6,14.981,24.1"

# Answers every line at once with a correct reply: the cost of the emulated plate is not measured.
RESPONDER = """
import os, sys
from slipscale.hardware.backends.serial_board import protocol as wire
master, status, buffer = int(sys.argv[1]), sys.argv[2], b""
while True:
    buffer += os.read(master, 4096)
    *lines, buffer = buffer.split(b"\\n")
    for line in lines:
        sequence, _ = wire.parse_command(line)
        os.write(master, wire.reply_frame(wire.BoardReply(sequence, "0000002A", 0, status)))
"""


def timed(action: Callable[[], object], count: int) -> list[float]:
    """Return the microseconds that each call took."""
    times = []
    for _ in range(count):
        begun = time.perf_counter_ns()
        action()
        times.append((time.perf_counter_ns() - begun) / 1e3)
    return times


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else ROUND_TRIPS
    master, slave = os.openpty()
    tty.setraw(slave)
    responder = subprocess.Popen(
        [sys.executable, "-c", RESPONDER, str(master), STATUS], pass_fds=[master]
    )
    try:
        port = os.ttyname(slave)
        line = SerialLine(port)
        link = BoardLink(line)
        bare = serial.Serial(port, timeout=1.0)
        frame = wire.command_frame(12_345, "STAT?")

        def bare_round_trip() -> None:
            bare.write(frame)
            bare.readline()

        bare_times, our_times = [], []
        timed(bare_round_trip, BATCH), timed(lambda: link.ask("STAT?"), BATCH)  # warm
        for _ in range(count // BATCH):
            bare_times += timed(bare_round_trip, BATCH)
            our_times += timed(lambda: link.ask("STAT?"), BATCH)
    finally:
        responder.terminate()
        responder.wait()
    print(f"{len(our_times)} round trips each, µs      median      p99")
    cuts = {}
    for name, times in (("bare write, readline", bare_times), ("checked command", our_times)):
        hundredths = quantiles(times, n=100)
        cuts[name] = hundredths[49], hundredths[98]
        print(f"{name:<34}{hundredths[49]:>8.1f} {hundredths[98]:>8.1f}")
    ours, theirs = cuts["checked command"], cuts["bare write, readline"]
    print(f"{'ratio':<34}{ours[0] / theirs[0]:>8.2f} {ours[1] / theirs[1]:>8.2f}   (goal: 1.5)")


if __name__ == "__main__":
    main()
