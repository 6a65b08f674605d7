"""Address of the HTTP server, and its guard: refuses foreign host names, foreign pages and missing tokens."""

import hmac
from dataclasses import dataclass
from ipaddress import ip_address
from typing import TypeAlias

from starlette.datastructures import Headers
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trajopt.server.limits import RequestRefused, Why
from trajopt.values.arrays import Value, at_least
from trajopt.values.errors import ProblemError
from trajopt.values.errors.arguments import checked

SHORTEST_TOKEN = 16
"""Characters of a token at least: fewer are guessed."""
LOCAL_NAMES = ("localhost", "127.0.0.1", "[::1]")
"""Names of this machine for local browsers and clients."""


def is_loopback(host: str) -> bool:
    """Return whether an address is reachable from this machine only."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


@checked
@dataclass(frozen=True, kw_only=True)
class HttpOptions(Value):
    """Address and access control of the server.

    Attributes:
        host: Address to listen on.
        port: Port; 0 for any free one.
        token: Required as `Authorization: Bearer TOKEN`; may be empty only on a loopback address.
        names: Accepted host names, in addition to the host.
        connections: Largest number of simultaneous connections.
        head: Time-out of a request's head after the connection [s].
        transfer: Time-out of a request's body, and of taking an answer [s].
    """

    host: str = "127.0.0.1"
    port: int = 8080
    token: str = ""
    names: tuple[str, ...] = ()
    connections: int = 512
    head: float = 10.0
    transfer: float = 30.0

    def __post_init__(self) -> None:
        """Refuse options that would admit every client.

        Raises:
            ProblemError: If other machines could connect without a token, or the token is short.
        """
        if not self.token and not is_loopback(self.host):
            raise ProblemError(
                f"on {self.host} other machines can connect: give a token, or listen on 127.0.0.1"
            )
        if self.token and len(self.token) < SHORTEST_TOKEN:
            raise ProblemError(f"a token has {SHORTEST_TOKEN} characters at least")
        at_least(self, 0, "port")
        at_least(self, 1, "connections")

    @property
    def hosts(self) -> frozenset[str]:
        """Accepted host names, in lower case; all if a token is required."""
        return frozenset(name.lower() for name in (*LOCAL_NAMES, self.host, *self.names))


OPEN = ("/health", "/", "/page.js", "/page.css")
"""Public paths: the health check, and a page without data."""
JSON, BYTES = "application/json", "application/octet-stream"
"""Accepted content types. A page of another site cannot send either without a preflight request."""
Denial: TypeAlias = tuple[int, str, str]
"""A status, a kind and a reason."""


class RequestGuard:
    """Checks each request for its origin, host and token.

    Otherwise a page of another site could use the server through a browser on this machine.
    """

    def __init__(self, app: ASGIApp, options: HttpOptions, attached: frozenset[str]) -> None:
        """Guard an application.

        Args:
            attached: Operations whose body is bytes instead of JSON.
        """
        self._app, self._options, self._attached = app, options, attached

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        denial = self._denial(Headers(scope=scope), scope["method"], scope["path"])
        if denial is None:
            await self._app(scope, receive, send)
            return
        status, kind, reason = denial
        body = {"error": {"kind": kind, "reason": reason}}
        headers = {"www-authenticate": "Bearer"} if status == 401 else None
        await JSONResponse(body, status, headers)(scope, receive, send)

    def _denial(self, headers: Headers, method: str, path: str) -> Denial | None:
        options = self._options
        host = headers.get("host", "").lower()
        name = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
        if not options.token and name not in options.hosts:
            return 421, "malformed", "the server is not known by that name"
        origin = headers.get("origin", "")
        if origin and origin.lower().partition("://")[2] != host:
            return 403, "malformed", "pages of other sites may not use the server"
        length = headers.get("content-length", "0")
        kind = headers.get("content-type", "").partition(";")[0].strip().lower()
        wanted = BYTES if path.rpartition("/")[2] in self._attached else JSON
        if method == "POST" and kind != wanted and (kind or length != "0"):
            return 415, "malformed", f"the request's body is {wanted}"
        if options.token and path not in OPEN and not self._knows(headers.get("authorization", "")):
            return 401, "malformed", "send the token: Authorization: Bearer TOKEN"
        return None

    def _knows(self, authorization: str) -> bool:
        scheme, _, token = authorization.partition(" ")
        right = hmac.compare_digest(token.encode(), self._options.token.encode())
        return right and scheme.lower() == "bearer"


AGAIN = 1.0
"""Delay before another try of a client that was refused for lack of memory [s]."""


class Intake:
    """Counts the bytes of bodies until their requests are answered.

    Raises:
        RequestRefused: If a body exceeds the remaining memory.
    """

    def __init__(self, app: ASGIApp, most: int) -> None:
        """Count the bytes read by an application.

        Args:
            most: Largest total size [bytes].
        """
        self._app, self._most, self._held = app, most, 0

    @property
    def held(self) -> int:
        return self._held

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        mine = 0

        async def received() -> Message:
            nonlocal mine
            message = await receive()
            length = len(message.get("body", b""))
            if self._held + length > self._most:
                reason = f"the requests that are under way have {self._most} bytes at most together"
                raise RequestRefused(Why.FULL, reason, retry_after=AGAIN)
            mine += length
            self._held += length
            return message

        try:
            await self._app(scope, received, send)
        finally:
            self._held -= mine
