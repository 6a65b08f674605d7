"""A server in a thread of the tests, with everything behind it, on a port that is free."""

import asyncio
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Event, Thread

import trajopt as to
from trajopt.server import Limits, Service
from trajopt.server.http import HttpOptions, Metrics, serve_http

MODULES = ("trajopt.server.operations", "tests.server.room")
SMALL = Limits(
    workers=1, cloud=100_000, waiting=8, waiting_per_session=8, grace=0.5, memory=512 * 2**20, body=2 * 2**20
)
PATIENT = HttpOptions(port=0, head=1.0, transfer=1.0, connections=64)


@dataclass
class Serving:
    """A server that is up.

    Attributes:
        port: Where.
        service: Its core; it belongs to the server's thread.
        metrics: Its numbers.
    """

    port: int
    service: Service
    metrics: Metrics

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"


@contextmanager
def serving(
    *robots: str | to.Robot,
    limits: Limits = SMALL,
    options: HttpOptions = PATIENT,
    modules: tuple[str, ...] = MODULES,
) -> Generator[Serving]:
    """Serve robots, installed ones or any, until the block ends."""
    up, found = Event(), list[Serving]()
    loop = asyncio.new_event_loop()
    stop = asyncio.Event()

    async def serve() -> None:
        metrics = Metrics()
        loaded = dict(
            (each, to.load(each)) if isinstance(each, str) else (each.name, each)
            for each in robots or ("planar2",)
        )
        async with Service(loaded, limits=limits, modules=modules, observer=metrics.count) as service:
            metrics.of(service)

            def ready(port: int) -> None:
                found.append(Serving(port, service, metrics))
                up.set()

            await serve_http(service, options, metrics=metrics, ready=ready, stop=stop)

    def run() -> None:
        try:
            loop.run_until_complete(serve())
        finally:
            up.set()
            loop.close()

    thread = Thread(target=run, name="server")
    thread.start()
    try:
        assert up.wait(60.0) and found, "the server did not come up"
        yield found[0]
    finally:
        if found:
            loop.call_soon_threadsafe(stop.set)
        thread.join(60.0)
        assert not thread.is_alive()
