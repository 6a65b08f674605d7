"""Serving a service over HTTP until it is told to end."""

import asyncio
import socket
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any, cast

import uvicorn

from trajopt.server.http.app import http_app
from trajopt.server.http.connections import Connections
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
        server = Server(_config(service, options, metrics))
        serving = asyncio.create_task(server.serve([listening]))
        try:
            while not server.started and not serving.done():
                await asyncio.sleep(0.01)
            if ready is not None and not serving.done():
                ready(int(listening.getsockname()[1]))
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
