"""Serve the console: provide the address, open a browser, and use TLS on a network."""

from __future__ import annotations

import asyncio
import ipaddress
import shutil
import socket
import subprocess
import sys
import webbrowser
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import uvicorn
from starlette.applications import Starlette
from uvicorn.protocols.http.h11_impl import H11Protocol

from slipscale.experiments.lab.console.app import Console, make_app
from slipscale.experiments.lab.console.jobs import Jobs
from slipscale.experiments.lab.console.security import TO_THE_PAGES, Access
from slipscale.faults import UserError
from slipscale.faults.private_folder import private_folder, write_private

PORT = 8470
CERTIFICATE_DAYS = "30"


def serve(*, port: int, lan: str | None, browser: bool) -> None:
    """Serve the console of the current folder until Ctrl-C.

    Parameters
    ----------
    port : int
        The port; 0 selects any free port.
    lan : str or None
        An address of this computer on the laboratory network, where the console uses TLS and is
        read-only. None restricts the console to this computer.
    browser : bool
        Whether to open a browser.

    Raises
    ------
    UserError
        If the port is in use, or the address does not belong to this computer.
    """
    if lan:
        _check_address(lan)
    listening = _listen(lan or "127.0.0.1", port)
    access = Access(
        host=lan or "127.0.0.1",
        port=listening.getsockname()[1],
        tls=bool(lan),
        read_only=bool(lan),
    )
    app, console = make_app(access, Jobs(Path.cwd()))
    with TemporaryDirectory() as place, listening:
        config = _configuration(app, access, Path(place))
        print(f"the console: {access.address}")
        only = "read-only, for everyone who has this address" if lan else "on this computer only"
        print(
            f"{only}; the address works once, in one browser; Ctrl-C closes the console but "
            "does not end sessions"
        )
        sys.stdout.flush()
        door = private_folder() / f"console-{access.port}.html"
        access.entrance.renewed = partial(_renew, access, door)
        write_private(door, TO_THE_PAGES.format(access.address))
        if browser:
            _open(door.as_uri())
        server = _Server(config, console)
        try:
            with suppress(KeyboardInterrupt):
                server.run(sockets=[listening])
        finally:
            door.unlink(missing_ok=True)


def _renew(access: Access, door: Path) -> None:
    """Print the console's new address, and update the file that redirects browsers to it."""
    write_private(door, TO_THE_PAGES.format(access.address))
    print(f"opened; for another browser: {access.address}", flush=True)


class _Impatient(H11Protocol):
    """HTTP protocol that closes a connection if no complete request arrives in time."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._wait_for_a_request()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.cycle is None or self.cycle.response_complete:
            self._wait_for_a_request()

    def _wait_for_a_request(self) -> None:
        self._unset_keepalive_if_required()
        self.timeout_keep_alive_task = self.loop.call_later(
            self.timeout_keep_alive, self.timeout_keep_alive_handler
        )


class _Server(uvicorn.Server):
    """A server that closes its event streams on shutdown, because it would wait for them."""

    def __init__(self, config: uvicorn.Config, console: Console) -> None:
        super().__init__(config)
        self._console = console

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        self._console.closing.set()
        await super().shutdown(sockets)


def _configuration(app: Starlette, access: Access, place: Path) -> uvicorn.Config:
    certificate = _certificate(access.host, place) if access.tls else None
    return uvicorn.Config(
        app,
        log_level="error",
        access_log=False,
        server_header=False,
        http=_Impatient,
        ws="none",  # Otherwise a WebSocket request ends in a traceback on the terminal.
        timeout_graceful_shutdown=3,
        ssl_certfile=certificate[0] if certificate else None,
        ssl_keyfile=certificate[1] if certificate else None,
    )


def _listen(host: str, port: int) -> socket.socket:
    try:
        return socket.create_server((host, port))
    except OSError as error:
        raise UserError(
            "port {port} at {host}: {reason}; is another console open there? Name another port "
            "with --port, or 0 for any free port",
            port=port,
            host=host,
            reason=error.strerror,
        ) from None


def _check_address(lan: str) -> None:
    """Raise `UserError` unless ``lan`` is a single IPv4 address that is not public."""
    try:
        address = ipaddress.ip_address(lan)
    except ValueError:
        address = None
    if address is None or address.version != 4 or address.is_unspecified or address.is_global:  # noqa: PLR2004
        raise UserError(
            "--lan {lan}: expected this computer's own address on the laboratory network, such "
            "as 192.168.0.12",
            lan=lan,
        )


def _certificate(host: str, place: Path) -> tuple[Path, Path]:
    """Return a short-lived self-signed certificate and its key."""
    openssl = shutil.which("openssl")
    if not openssl:
        raise UserError(
            "--lan needs openssl to create a certificate; install it, or use an ssh tunnel from "
            "another room: ssh -L {port}:127.0.0.1:{port} THIS-COMPUTER",
            port=PORT,
        )
    certificate, key = place / "certificate.pem", place / "key.pem"
    command = [openssl, "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
    command += ["-nodes", "-days", CERTIFICATE_DAYS, "-subj", f"/CN={host}"]
    command += ["-addext", f"subjectAltName=IP:{host}", "-out", str(certificate)]
    made = subprocess.run(  # noqa: S603 - our own arguments, and a checked address
        [*command, "-keyout", str(key)], capture_output=True, text=True, check=False
    )
    if made.returncode:
        raise UserError(
            "openssl failed to create a certificate: {reason}",
            reason=made.stderr.strip().splitlines()[-1],
        )
    return certificate, key


def _open(address: str) -> None:
    """If a browser is available, use it to open the file that redirects to the console.

    The console's own address contains the token and is not passed as an argument, because other
    users can read a program's arguments.
    """
    try:
        opened = webbrowser.open(address)
    except webbrowser.Error:
        opened = False
    if not opened:
        print("no browser could be opened; open the address yourself", file=sys.stderr)
