"""A viser server whose page and WebSocket ask a guard first."""

import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from importlib import import_module
from types import SimpleNamespace
from typing import Any, cast

from viser import ViserServer
from websockets.http11 import Request, Response

from trajopt.values.errors import ProblemError
from trajopt.viewer.guard import PageGuard

_STARTS = threading.Lock()


class GuardedServer(ViserServer):
    """A server of one page, which opens only by the address with the secret.

    Attributes:
        address: The address of the page.
    """

    address: str

    def __init__(self, host: str, port: int) -> None:
        """Start to serve an empty page.

        Args:
            host: Address to serve on.
            port: Port; the next free one if it is taken.

        Raises:
            ProblemError: If the installed viser cannot be guarded.
        """
        guard = PageGuard(host)
        with _asking(guard):
            super().__init__(host, port, "trajopt", verbose=False)  # pyright: ignore[reportUnknownMemberType]
        name = "localhost" if host == "0.0.0.0" else f"[{host}]" if ":" in host else host
        self.address = f"http://{name}:{self.get_port()}/{guard.secret}/"


@contextmanager
def _asking(guard: PageGuard) -> Generator[None]:
    """Have a viser server that starts within this context ask a guard before it answers.

    viser has no hook for this, so the name `websockets` of its module is bound, while it starts, to a
    namespace whose `serve` asks the guard first.

    Raises:
        ProblemError: If viser started without asking: its page would be open to every web page.
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
