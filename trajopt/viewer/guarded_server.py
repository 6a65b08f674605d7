"""A viser server with a guard for its page and WebSocket."""

import hmac
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from http import HTTPStatus
from importlib import import_module
from secrets import token_urlsafe
from types import SimpleNamespace
from typing import Any, cast

from viser import ViserServer
from websockets.http11 import Request, Response

from trajopt.values.errors import ProblemError

LOCAL_NAMES = frozenset(("localhost", "127.0.0.1", "::1"))
"""Names by which a browser on this machine calls it."""


@dataclass(frozen=True)
class PageGuard:
    """Checks each request for a page before it is answered, and each WebSocket before it opens.

    Browsers do not apply the same-origin policy to WebSockets (RFC 6455, section 10.2), and a foreign page
    can map its own name to this machine's address (DNS rebinding).

    Attributes:
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
        return replace(request, path=request.path.removeprefix(f"/{self.secret}") or "/")


def _first(path: str) -> str:
    return path.partition("?")[0].removeprefix("/").partition("/")[0]


_STARTS = threading.Lock()


class GuardedServer(ViserServer):
    """A server of one page, which opens only by the address with the secret."""

    address: str

    def __init__(self, host: str, port: int) -> None:
        guard = PageGuard(host)
        with _asking(guard):
            super().__init__(host, port, "trajopt", verbose=False)  # pyright: ignore[reportUnknownMemberType]
        name = "localhost" if host == "0.0.0.0" else f"[{host}]" if ":" in host else host
        self.address = f"http://{name}:{self.get_port()}/{guard.secret}/"


@contextmanager
def _asking(guard: PageGuard) -> Generator[None]:
    """Make a viser server that starts within this context consult a guard before each answer.

    viser has no hook for this, so the name `websockets` of its module is bound to a namespace whose `serve`
    consults the guard.
    """
    infra: Any = import_module("viser.infra._infra")
    original: Any = infra.websockets
    asks: list[bool] = []

    def serve(*where: Any, process_request: Callable[..., Response | None], **options: Any) -> Any:
        asks.append(True)

        def guarded(connection: Any, request: Request) -> Response | None:
            refused = guard.refusal(request)
            if refused is not None:
                return cast(Response, connection.respond(refused[0], f"{refused[1]}\n"))
            return process_request(connection, guard.without_secret(request))

        return original.asyncio.server.serve(*where, process_request=guarded, **options)

    server = SimpleNamespace(serve=serve, ServerConnection=original.asyncio.server.ServerConnection)
    with _STARTS:
        infra.websockets = SimpleNamespace(
            asyncio=SimpleNamespace(server=server),
            datastructures=original.datastructures,
            exceptions=original.exceptions,
        )
        try:
            yield
        finally:
            infra.websockets = original
    if not asks:
        raise ProblemError("the installed viser cannot be guarded: every web page could use the page")
