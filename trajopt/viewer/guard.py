"""Access to a page: by its own windows only, opened by an address that holds a secret."""

import hmac
from dataclasses import dataclass, field, replace
from http import HTTPStatus
from secrets import token_urlsafe
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from websockets.http11 import Request

LOCAL_NAMES = frozenset(("localhost", "127.0.0.1", "::1"))
"""Names by which a browser on this machine calls it."""


@dataclass(frozen=True)
class PageGuard:
    """Checks each request for a page before it is answered, and each WebSocket before it opens.

    A WebSocket of any web page reaches a port of this machine: browsers do not apply the same-origin policy
    to it (RFC 6455, section 10.2). And a foreign page can give this machine's address its own name (DNS
    rebinding).

    Attributes:
        host: Address that the page is served on.
        secret: First part of the path of each request.
    """

    host: str
    secret: str = field(default_factory=lambda: token_urlsafe(16))

    def refusal(self, request: "Request") -> tuple[HTTPStatus, str] | None:
        """Return status and reason if a request is to be refused, None if it may pass."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return HTTPStatus.BAD_REQUEST, "needs one Host and at most one Origin"
        called = hosts[0].lower()
        name = called.rpartition(":")[0] if called.rpartition(":")[2].isdigit() else called
        if self.host in LOCAL_NAMES and name.strip("[]") not in LOCAL_NAMES:
            return HTTPStatus.MISDIRECTED_REQUEST, "this page is served to this machine only"
        if origins and origins[0].lower().partition("://")[2] != called:
            return HTTPStatus.FORBIDDEN, "other web pages may not use this page"
        if not hmac.compare_digest(
            _first(request.path).encode(errors="surrogateescape"), self.secret.encode()
        ):
            return HTTPStatus.FORBIDDEN, "open the address that trajopt printed: it holds a secret"
        return None

    def without_secret(self, request: "Request") -> "Request":
        """Return the request that viser sees: without the secret in its path."""
        return replace(request, path=request.path.removeprefix(f"/{self.secret}") or "/")


def _first(path: str) -> str:
    """Return the first part of a path."""
    return path.partition("?")[0].removeprefix("/").partition("/")[0]
