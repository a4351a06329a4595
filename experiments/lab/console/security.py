"""Access control for the console, as one layer in front of all pages.

Every request that does not clearly come from the operator's own browser is rejected before it
reaches a page:

- Connections from other users of this computer are rejected. Cookies are not tied to a port, so
  another user's web page could otherwise receive the console's cookie.
- The address shown in the terminal contains a token that works once, in one browser. The browser
  then receives a secret in a cookie, and a new token is generated for the next browser.
- The host name must be this console's own. Other names that resolve to this computer are rejected.
- Requests that make changes require this console's origin and a header that a form on another
  website cannot send.
"""

from __future__ import annotations

import os
import secrets
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from urllib.parse import parse_qs, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from slipscale.experiments.lab.console.page_texts import Words, languages, preferred

LARGEST_BODY = 1_000_000
# Largest body for an uploaded table, whose text in JSON is longer than the table.
LARGEST_UPLOAD = 15_000_000
UPLOAD = "/do/upload"
TO_THE_PAGES = (
    '<!doctype html><meta http-equiv="refresh" content="0;url={}"><title>Slipscale</title>'
    '<link rel="icon" href="/static/icon.svg">'  # otherwise the browser would request favicon.ico
)
CONNECTIONS = Path("/proc/net/tcp")  # on Linux, lists the owner of each connection
ESTABLISHED = "01"
ROOT = 0
ASKING = "x-slipscale"  # a request header that HTML forms of other sites cannot set
READING = ("GET", "HEAD")
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# A report is a complete page with embedded styles and figures; it runs no scripts.
REPORT_POLICY = (
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:; font-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)


class Entrance:
    """One-time token for opening the console, and the secret in the cookies of admitted browsers.

    Attributes
    ----------
    renewed : callable
        Called after a used token has been replaced.
    """

    def __init__(self) -> None:
        self.token = secrets.token_urlsafe(24)
        self.secret = secrets.token_urlsafe(24)
        self.renewed: Callable[[], None] = lambda: None

    def opens(self, given: str) -> bool:
        """Return whether a token is valid. A valid token works only once, and is then replaced."""
        opened = secrets.compare_digest(given.encode(), self.token.encode())
        if opened:
            self.token = secrets.token_urlsafe(24)
            self.renewed()
        return opened

    def admits(self, held: str) -> bool:
        """Return whether a browser's cookie contains the secret."""
        return secrets.compare_digest(held.encode(), self.secret.encode())


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """The console's address, and the rules for access to it.

    Parameters
    ----------
    host, port
        The address on which the console listens.
    tls : bool
        Whether the console uses TLS.
    read_only : bool
        Whether the console rejects all actions, for example on the laboratory network.
    entrance : Entrance
        Checks tokens and cookies.
    """

    host: str = "127.0.0.1"
    port: int
    tls: bool = False
    read_only: bool = False
    entrance: Entrance = field(default_factory=Entrance, repr=False)

    @property
    def hosts(self) -> frozenset[str]:
        """The accepted host names."""
        names = {self.host, "localhost"} if self.host == "127.0.0.1" else {self.host}
        return frozenset(f"{name}:{self.port}" for name in names)

    @property
    def origins(self) -> frozenset[str]:
        """The accepted origins."""
        scheme = "https" if self.tls else "http"
        return frozenset(f"{scheme}://{host}" for host in self.hosts)

    @property
    def address(self) -> str:
        """The address to open, including the token."""
        scheme = "https" if self.tls else "http"
        return f"{scheme}://{self.host}:{self.port}/?{urlencode({'token': self.entrance.token})}"

    @property
    def cookie(self) -> str:
        """The cookie's name; it includes the port because cookies are not tied to one."""
        return f"slipscale-{self.port}"


class Guard:
    """Rejects requests that `Access` does not allow, and sets the headers of every response."""

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app = app
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Reject the request, or pass it on to the application."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refusal = (
            self._refusal(scope)
            if scope["type"] == "http"
            else _refused("not served", 403, Headers(scope=scope))
        )
        await (refusal or self._app)(scope, receive, self._with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        """Return the response to a rejected or redirected request; None if a page may respond."""
        headers, access = Headers(scope=scope), self._access
        if not access.tls and belongs_to_another(scope.get("client")):
            return _refused("This console belongs to another user.", 403, headers)
        if headers.get("host", "") not in access.hosts:
            return _refused("This is not the console's address.", 400, headers)
        query = parse_qs(scope["query_string"].decode("latin-1"))
        given = query.get("token", [""])[0]
        if given and scope["method"] in READING and access.entrance.opens(given):
            # Remove the token from the address bar. A redirect would not work, because a browser
            # that opened a local file does not send strict cookies to the redirect's target.
            chosen = query.get("lang", [""])[0]
            language = f"?lang={chosen}" if chosen in languages() else ""
            opened = HTMLResponse(TO_THE_PAGES.format(f"/{language}"))
            secret = access.entrance.secret
            opened.set_cookie(
                access.cookie, secret, httponly=True, samesite="strict", secure=access.tls
            )
            return opened
        if not access.entrance.admits(self._held(headers)):
            sentence = "Open the address that slipscale lab shows in the terminal."
            return _refused(sentence, 403, headers)
        if scope["method"] in READING:
            return None
        return self._change_refusal(scope, headers)

    def _change_refusal(self, scope: Scope, headers: Headers) -> Response | None:
        """Return the response that rejects a forbidden change; None if the change is allowed."""
        length = headers.get("content-length", "")
        most = LARGEST_UPLOAD if scope["path"] == UPLOAD else LARGEST_BODY
        ours = headers.get("origin") in self._access.origins and headers.get(ASKING) == "1"
        reasons = {
            "Only GET and POST are supported.": scope["method"] != "POST",
            "This console is read-only.": self._access.read_only,
            "The request comes from another page.": not ours,
            "Expected JSON.": headers.get("content-type", "").split(";")[0] != "application/json",
            "Too long.": not length.isdecimal() or int(length) > most,
        }
        return next(
            (_refused(reason, 403, headers) for reason, holds in reasons.items() if holds), None
        )

    def _held(self, headers: Headers) -> str:
        """Return the content of the console's cookie; empty if there is none."""
        try:
            cookies = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return ""
        held = cookies.get(self._access.cookie)
        return held.value if held else ""

    def _with_headers(self, send: Send) -> Send:
        """Wrap ``send``, so that each response includes the security headers."""

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
    """Return whether a connection comes from another user of this computer.

    Parameters
    ----------
    client : tuple
        Host and port of the client. The function returns False if ``client`` is None or the host is
        not an IP address, as in tests.
    """
    if sys.platform == "win32" or client is None or not CONNECTIONS.exists():
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
    return True  # the client has already disconnected


def _refused(sentence: str, status: int, headers: Headers) -> PlainTextResponse:
    """Return the response to a rejected request, in the browser's language."""
    say = Words(preferred(headers.get("accept-language", ""), "")).say
    return PlainTextResponse(f"{say(sentence)}\n", status_code=status)
