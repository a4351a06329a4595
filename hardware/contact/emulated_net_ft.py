"""Emulate an ATI Net F/T box, which sends forces as datagrams.

    python -m slipscale.hardware.contact.emulated_net_ft [--rate 1000]

This command prints the SPEC for ``--force``, and sends the forces of a finger that strokes back and
forth, as `slipscale.hardware.contact.emulated_line` does.
"""

from __future__ import annotations

import argparse
import socket
from collections.abc import Callable, Iterator
from threading import Event, Thread
from typing import Self

from slipscale.hardware.contact.net_ft import HEADER, RECORD, REQUEST, STREAM

COUNTS_PER_N = 1_000_000
Forces = Callable[[float], tuple[float, float, float]]


def record(sequence: int, forces_n: tuple[float, float, float], status: int = 0) -> bytes:
    """Return the datagram with forces along x, y and z, and no torques."""
    counts = [round(each * COUNTS_PER_N) for each in forces_n]
    return RECORD.pack(sequence % 2**32, sequence % 2**32, status, *counts, 0, 0, 0)


def stroking(time_s: float) -> tuple[float, float, float]:
    """Return the forces on the transducer while a finger strokes at 1 Hz with 0.5 N."""
    return (0.3 if time_s % 1 < 0.5 else -0.3, 0.0, -0.5)  # noqa: PLR2004 - half of a period


class EmulatedNetFT:
    """Context manager for an emulated box on this computer.

    Parameters
    ----------
    forces : callable
        Function that takes the time since the start in seconds and returns forces in N.
    rate_hz : float
        Records per second.
    datagrams : callable, optional
        Function that takes the number of a record and its datagram, and yields the datagrams that
        are sent instead: none for a lost record, changed bytes for a fault.
    """

    def __init__(
        self,
        forces: Forces = stroking,
        *,
        rate_hz: float = 200.0,
        datagrams: Callable[[int, bytes], Iterator[bytes]] | None = None,
    ) -> None:
        self._forces = forces
        self._rate_hz = rate_hz
        self._datagrams = datagrams
        self._stop = Event()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(1 / rate_hz)
        self._thread = Thread(target=self._run, name="emulated Net F/T", daemon=True)
        self.commands: list[int] = []

    @property
    def spec(self) -> str:
        """The SPEC for ``--force``."""
        port = self._socket.getsockname()[1]
        return f"ati:127.0.0.1,port={port},counts_per_n={COUNTS_PER_N}"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._stop.set()
        self._thread.join()
        self._socket.close()

    def _run(self) -> None:
        client, number = None, 0
        while not self._stop.is_set():
            try:
                data, sender = self._socket.recvfrom(REQUEST.size)
            except TimeoutError:
                pass
            except ConnectionError:
                client = None  # Windows reports that the program ended
            else:
                header, command, _ = REQUEST.unpack(data)
                if header == HEADER:
                    self.commands.append(command)
                    client, number = (sender if command == STREAM else None), 0
            if client is not None:
                number += 1
                sent = record(number, self._forces(number / self._rate_hz))
                for each in self._datagrams(number, sent) if self._datagrams else (sent,):
                    self._socket.sendto(each, client)


def main() -> None:
    """Send forces until the process is interrupted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rate", type=float, default=1000.0, help="records per second")
    with EmulatedNetFT(rate_hz=parser.parse_args().rate) as box:
        print(box.spec, flush=True)
        try:
            Event().wait()
        except KeyboardInterrupt:
            return


if __name__ == "__main__":
    main()
