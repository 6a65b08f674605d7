"""Serving a service over HTTP until it is told to end."""

import asyncio
import socket
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, cast

import uvicorn
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from trajopt.server.http.app import http_app
from trajopt.server.http.metrics import Metrics
from trajopt.server.http.options import HttpOptions
from trajopt.server.service import Service

LARGEST_HEAD = 16 * 1024
"""Bytes of a request's head."""
IDLE = 5.0
"""A connection on which nothing is asked is closed after so long [s]."""


async def serve_http(
    service: Service,
    options: HttpOptions,
    *,
    metrics: Metrics | None = None,
    ready: Callable[[int], None] | None = None,
    stop: asyncio.Event | None = None,
) -> None:
    """Serve until it is cancelled, or told to stop.

    Args:
        service: The service, started.
        options: Where it listens, and whom it lets in.
        metrics: What `/metrics` shows.
        ready: Called with the port, once it listens.
        stop: Set to end.

    Raises:
        OSError: If it cannot listen there.
    """
    family = socket.AF_INET6 if ":" in options.host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((options.host, options.port))
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
    """Return uvicorn's configuration, with connections that are cut off where a client is too slow."""
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
    """Uvicorn's server, which leaves signals to who runs it: there is more to end than this."""

    @contextmanager
    def capture_signals(self) -> Generator[None]:
        """Capture none."""
        yield


class Connections:
    """The open connections of a server.

    It stands between uvicorn and the network, and between uvicorn and the application: the first tells when a
    client sends and takes bytes, the second when a request's head is there and when it is answered.
    """

    def __init__(self, app: ASGIApp, options: HttpOptions) -> None:
        """Take the application, and how slow a client may be.

        Args:
            app: The application.
            options: Seconds that a client has, and how many connections there may be.
        """
        self._app, self._options = app, options
        self._open: dict[object, Connection] = {}

    def __len__(self) -> int:
        """Return how many are open."""
        return len(self._open)

    def connected(self, protocol: asyncio.Protocol) -> asyncio.Protocol:
        """Return a protocol that does what another one does, and cuts off clients that are too slow.

        Args:
            protocol: Speaks HTTP on one connection.
        """
        return Connection(protocol, self._open, self._options)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on to the application, and tell its connection when it begins and ends."""
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
    """One connection; another protocol speaks HTTP on it."""

    def __init__(
        self, inner: asyncio.Protocol, connections: dict[object, "Connection"], options: HttpOptions
    ) -> None:
        """Take the protocol, and the open connections by the address of their clients."""
        self._inner, self._connections, self._options = inner, connections, options
        self._loop = asyncio.get_running_loop()
        self._head: asyncio.TimerHandle | None = None
        self._taking: asyncio.TimerHandle | None = None
        self._under_way, self._client = 0, cast(object, self)

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to wait for a request."""
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
        """Pass on what comes; the head of a request must come as a whole, in time."""
        if not self._under_way and self._head is None:
            self._expect()
        self._inner.data_received(data)

    def eof_received(self) -> bool | None:
        """Pass on that the client sends no more."""
        return self._inner.eof_received()

    def pause_writing(self) -> None:
        """Wait for the client to take what is there for it."""
        self._inner.pause_writing()
        self._taken_in_time()

    def resume_writing(self) -> None:
        """Go on: it has taken some."""
        self._taken()
        self._inner.resume_writing()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing more."""
        self._connections.pop(self._client, None)
        self._heard()
        self._taken()
        self._inner.connection_lost(exc)

    def asked(self) -> None:
        """Wait for no head any more: one is there."""
        self._under_way += 1
        self._heard()

    def answered(self, *, complete: bool) -> None:
        """Give the client time for the rest of a body that nobody waits for, and to take the answer.

        Args:
            complete: Whether the whole request was there.
        """
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
