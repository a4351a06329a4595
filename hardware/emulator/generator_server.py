"""Serve simulated function generators on a socket."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from typing import Self

from slipscale.hardware.emulator.generators import MAKES

LOOKS_S = 0.1  # interval at which the server checks whether to end


class GeneratorServer:
    """Server for a simulated generator, with one client at a time.

    Parameters
    ----------
    make : str
        One of `slipscale.hardware.emulator.generators.MAKES`.

    Attributes
    ----------
    generator : SimulatedGenerator
        The simulated generator.
    resource : str
        VISA resource for ``scpi:RESOURCE``.
    lines : list of str
        Received lines.
    drop_at : int or None
        Number of the received line at which the server closes the connection without an answer.
    for_good : bool
        Whether the server, after this line, also closes all later connections.
    """

    def __init__(self, make: str) -> None:
        self.generator = MAKES[make]()
        self.lines: list[str] = []
        self.drop_at: int | None = None
        self.for_good = False
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.resource = f"TCPIP::127.0.0.1::{self._socket.getsockname()[1]}::SOCKET"
        self._over = False
        self._thread = threading.Thread(target=self._serve, name="generator", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop the server."""
        self._over = True
        with socket.socket() as poke:
            poke.connect_ex(self._socket.getsockname())
        self._thread.join()
        self._socket.close()

    def _serve(self) -> None:
        while not self._over:
            connection, _ = self._socket.accept()
            with connection, suppress(ConnectionError):  # The client may close the connection.
                if not (self._over or (self.for_good and self._dropped())):
                    self._talk(connection)

    def _dropped(self) -> bool:
        return self.drop_at is not None and len(self.lines) >= self.drop_at

    def _talk(self, connection: socket.socket) -> None:
        buffer = b""
        connection.settimeout(LOOKS_S)
        while not self._over:
            if hasattr(socket, "TCP_QUICKACK"):  # avoids 40 ms of delay per command
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            try:
                received = connection.recv(4096)
            except TimeoutError:
                continue
            if not received:
                return
            *lines, buffer = (buffer + received).split(b"\n")
            for raw in lines:
                self.lines.append(raw.decode().strip())
                if len(self.lines) == self.drop_at:
                    return
                answer = self.generator.hear(self.lines[-1])
                if answer is not None:
                    connection.sendall(answer.encode() + b"\n")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()
