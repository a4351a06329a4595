"""Who may see the console, and who may ask it for something: one layer before every page.

The rule that governs this file: **what is not plainly the operator's own browser is refused before
any page is looked at.**

- On this computer, another user's connection is refused, whatever it holds: cookies know no ports,
  so another user's web page could receive ours.
- The address that the terminal shows holds a token that opens one browser, once. The browser gets
  another secret for it, in a cookie; the next address has a new token.
- The host name must be this console's; a foreign name that resolves to this machine is not.
- What changes something needs this console's origin, and a header that no form of another site can
  send.
"""

from __future__ import annotations

import os
import secrets
import socket
from contextlib import suppress
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import HTMLResponse, PlainTextResponse

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.responses import Response
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

LARGEST_BODY = 1_000_000
TO_THE_PAGES = (
    '<!doctype html><meta http-equiv="refresh" content="0;url={}"><title>Slipscale</title>'
)
CONNECTIONS = Path("/proc/net/tcp")  # Linux: who holds each
ESTABLISHED = "01"
ROOT = 0
ASKING = "x-slipscale"  # the header that no form of another site can send
READING = ("GET", "HEAD")
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# A report is a whole page of its own, with its styles and figures inside; it runs nothing.
REPORT_POLICY = (
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)


class Entrance:
    """The token that opens the next browser, and the secret that each browser keeps.

    Attributes
    ----------
    renewed : callable
        Called when a token was used and there is a new one.
    """

    def __init__(self) -> None:
        self.token = secrets.token_urlsafe(24)
        self.secret = secrets.token_urlsafe(24)
        self.renewed: Callable[[], None] = lambda: None

    def opens(self, given: str) -> bool:
        """Return whether a token is the one that opens; it does so once."""
        opened = secrets.compare_digest(given.encode(), self.token.encode())
        if opened:
            self.token = secrets.token_urlsafe(24)
            self.renewed()
        return opened

    def admits(self, held: str) -> bool:
        """Return whether a browser's cookie holds the secret."""
        return secrets.compare_digest(held.encode(), self.secret.encode())


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """Where a console is reached, and by whom.

    Parameters
    ----------
    host, port
        The address it listens on.
    tls : bool
        Whether it speaks TLS.
    read_only : bool
        Whether nothing can be asked of it: for a phone in the laboratory's network.
    entrance : Entrance
        What opens it.
    """

    host: str = "127.0.0.1"
    port: int
    tls: bool = False
    read_only: bool = False
    entrance: Entrance = field(default_factory=Entrance, repr=False)

    @property
    def hosts(self) -> frozenset[str]:
        """The host names that a browser may ask for."""
        names = {self.host, "localhost"} if self.host == "127.0.0.1" else {self.host}
        return frozenset(f"{name}:{self.port}" for name in names)

    @property
    def origins(self) -> frozenset[str]:
        """The origins that a request may come from."""
        scheme = "https" if self.tls else "http"
        return frozenset(f"{scheme}://{host}" for host in self.hosts)

    @property
    def address(self) -> str:
        """The address to open, with the token."""
        scheme = "https" if self.tls else "http"
        return f"{scheme}://{self.host}:{self.port}/?{urlencode({'token': self.entrance.token})}"

    @property
    def cookie(self) -> str:
        """The cookie's name: cookies know no ports, and two consoles may run."""
        return f"slipscale-{self.port}"


class Guard:
    """Refuses what `Access` does not allow; sets the headers of every answer."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or hand on."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope) if scope["type"] == "http" else _refused("not served", 403)
        await (refusal or self._app)(scope, receive, self._with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        """Return the answer to what is refused or redirected; None where a page may answer."""
        headers, access = Headers(scope=scope), self._access
        if not access.tls and belongs_to_another(scope.get("client")):
            return _refused("This console is another user's.", 403)
        if headers.get("host", "") not in access.hosts:
            return _refused("This is not the console's address.", 400)
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        if given and scope["method"] in READING and access.entrance.opens(given):
            # The token leaves the address line. No redirect: a browser that came from a file sends
            # no strict cookie to where one leads.
            opened = HTMLResponse(TO_THE_PAGES.format("/"))
            secret = access.entrance.secret
            opened.set_cookie(
                access.cookie, secret, httponly=True, samesite="strict", secure=access.tls
            )
            return opened
        if not access.entrance.admits(self._held(headers)):
            return _refused("Open the address that the terminal shows (slipscale lab).", 403)
        if scope["method"] in READING:
            return None
        return self._change_refusal(scope["method"], headers)

    def _change_refusal(self, method: str, headers: Headers) -> Response | None:
        """Return the answer to a request that would change something, and may not."""
        length = headers.get("content-length", "")
        ours = headers.get("origin") in self._access.origins and headers.get(ASKING) == "1"
        reasons = {
            "Only GET and POST are answered.": method != "POST",
            "This console only shows.": self._access.read_only,
            "The request comes from another page.": not ours,
            "Expected JSON.": headers.get("content-type", "").split(";")[0] != "application/json",
            "Too long.": not length.isdecimal() or int(length) > LARGEST_BODY,
        }
        return next((_refused(reason, 403) for reason, holds in reasons.items() if holds), None)

    def _held(self, headers: Headers) -> str:
        """Return what the browser's cookie holds, or nothing."""
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return ""
        held = cookies.get(self._access.cookie)
        return held.value if held else ""

    def _with_headers(self, send: Send) -> Send:
        """Return a `send` that adds to each answer what a browser must keep to."""

        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.setdefault("content-security-policy", POLICY)
                headers["cache-control"] = "no-store"
                headers["x-content-type-options"] = "nosniff"
                headers["referrer-policy"] = "no-referrer"
                headers["cross-origin-opener-policy"] = "same-origin"
                headers["cross-origin-resource-policy"] = "same-origin"
            await send(message)

        return sending


def belongs_to_another(client: tuple[str, int] | None) -> bool:
    """Return whether another user of this computer holds the other end of a connection.

    Parameters
    ----------
    client : tuple
        Host and port of the other end. A name is no connection: a test's.
    """
    if client is None or not CONNECTIONS.exists():
        return False
    try:
        number = socket.inet_aton(client[0])[::-1].hex().upper()
    except OSError:
        return False
    wanted = f"{number}:{client[1]:04X}"
    with suppress(OSError):
        for line in CONNECTIONS.read_text(encoding="ascii").splitlines()[1:]:
            _, here, _, state, *_, user = line.split()[:8]
            if (here, state) == (wanted, ESTABLISHED):
                return int(user) not in (os.getuid(), ROOT)
    return True  # it has hung up already


def _refused(sentence: str, status: int) -> PlainTextResponse:
    return PlainTextResponse(f"{sentence}\n", status_code=status)
