"""Serving a service over HTTP, with time-outs for slow clients."""

import asyncio
import socket
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, cast

import uvicorn
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trajopt.server.http.answers import HttpOptions
from trajopt.server.http.app import Metrics, http_app
from trajopt.server.service import Service
from trajopt.values.errors import ProblemError, shown

LARGEST_HEAD = 16 * 1024
"""Bytes of a request's head."""
IDLE = 5.0
"""Time-out of an idle connection [s]."""


async def serve_http(
    service: Service,
    options: HttpOptions,
    *,
    metrics: Metrics | None = None,
    ready: Callable[[int], None] | None = None,
    stop: asyncio.Event | None = None,
) -> None:
    """Serve until cancelled or stopped; `ready` is called with the port once it listens."""
    family = socket.AF_INET6 if ":" in options.host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((options.host, options.port))
        except (OSError, OverflowError) as error:
            raise ProblemError(
                f"nothing can be served on {shown(options.host)}, port {options.port}: {error}"
            ) from error
        options = replace(options, port=int(listening.getsockname()[1]))
        server = Server(_config(service, options, metrics))
        serving = asyncio.create_task(server.serve([listening]))
        try:
            while not server.started and not serving.done():
                await asyncio.sleep(0.01)
            if ready is not None and not serving.done():
                ready(options.port)
            waits = {serving} if stop is None else {serving, asyncio.create_task(stop.wait())}
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        finally:
            server.should_exit = True
            await serving


def _config(service: Service, options: HttpOptions, metrics: Metrics | None) -> uvicorn.Config:
    connections = Connections(http_app(service, options, metrics), options)
    config = uvicorn.Config(
        connections,
        http="h11",
        ws="none",
        lifespan="off",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,  # the address of a client is that of its connection
        h11_max_incomplete_event_size=LARGEST_HEAD,
        timeout_keep_alive=int(IDLE),
        timeout_graceful_shutdown=int(service.limits.grace) + 1,
        backlog=options.connections,
    )
    config.load()
    speaks: Callable[..., asyncio.Protocol] = config.http_protocol_class

    def connected(**arguments: Any) -> asyncio.Protocol:
        return connections.connected(speaks(**arguments))

    config.http_protocol_class = cast("type[asyncio.Protocol]", connected)
    return config


class Server(uvicorn.Server):
    """Uvicorn's server without its signal handlers, since the caller has more to end."""

    @contextmanager
    def capture_signals(self) -> Generator[None]:
        yield


class Connections:
    """The open connections of a server.

    It wraps uvicorn's protocol and the application, which report bytes and requests.
    """

    def __init__(self, app: ASGIApp, options: HttpOptions) -> None:
        self._app, self._options = app, options
        self._open: dict[object, Connection] = {}

    def __len__(self) -> int:
        return len(self._open)

    def connected(self, protocol: asyncio.Protocol) -> asyncio.Protocol:
        return Connection(protocol, self._open, self._options)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        connection = self._open.get(scope.get("client"))
        if connection is None:
            await self._app(scope, receive, send)
            return
        complete = not any(name in (b"content-length", b"transfer-encoding") for name, _ in scope["headers"])

        async def received() -> Message:
            nonlocal complete
            message = await receive()
            complete = complete or not message.get("more_body", False)
            return message

        connection.asked()
        try:
            await self._app(scope, received, send)
        finally:
            connection.answered(complete=complete)


class Connection(asyncio.Protocol):
    """One connection with its time-outs, around a protocol that implements HTTP."""

    def __init__(
        self, inner: asyncio.Protocol, connections: dict[object, "Connection"], options: HttpOptions
    ) -> None:
        self._inner, self._connections, self._options = inner, connections, options
        self._loop = asyncio.get_running_loop()
        self._head: asyncio.TimerHandle | None = None
        self._taking: asyncio.TimerHandle | None = None
        self._under_way, self._client = 0, cast(object, self)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start to wait for a request."""
        self._transport = cast(asyncio.Transport, transport)
        connected = cast("socket.socket", transport.get_extra_info("socket"))
        # A client whose machine is gone would never be missed otherwise.
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        peer: Any = transport.get_extra_info("peername")
        if peer:
            self._client = (str(peer[0]), int(peer[1]))  # as uvicorn tells it to the application
        self._inner.connection_made(transport)
        self._connections[self._client] = self
        if len(self._connections) > self._options.connections:
            self._transport.abort()
        else:
            self._expect()

    def data_received(self, data: bytes) -> None:
        """Pass data on; the whole head of a request must arrive in time."""
        if not self._under_way and self._head is None:
            self._expect()
        self._inner.data_received(data)

    def eof_received(self) -> bool | None:
        """Pass on the end of the client's data."""
        return self._inner.eof_received()

    def pause_writing(self) -> None:
        """Start the time-out for taking the answer."""
        self._inner.pause_writing()
        self._taken_in_time()

    def resume_writing(self) -> None:
        """End the time-out: the client has read."""
        self._taken()
        self._inner.resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing more."""
        self._connections.pop(self._client, None)
        self._heard()
        self._taken()
        self._inner.connection_lost(exc)

    def asked(self) -> None:
        """End the time-out of the head."""
        self._under_way += 1
        self._heard()

    def answered(self, *, complete: bool) -> None:
        """Start the time-out for the rest of an unread body, and for taking the answer."""
        self._under_way -= 1
        if not complete:
            self._expect()
        if self._transport.get_write_buffer_size() and self._taking is None:
            self._taken_in_time()

    def _expect(self) -> None:
        self._head = self._loop.call_later(self._options.head, self._transport.abort)

    def _heard(self) -> None:
        if self._head is not None:
            self._head.cancel()
            self._head = None

    def _taken_in_time(self) -> None:
        self._taking = self._loop.call_later(self._options.transfer, self._cut_off)

    def _taken(self) -> None:
        if self._taking is not None:
            self._taking.cancel()
            self._taking = None

    def _cut_off(self) -> None:
        self._taking = None
        if self._transport.get_write_buffer_size():
            self._transport.abort()
