"""A service with all its faces, until the process is told to end."""

import asyncio
import signal
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import TypeAlias

from trajopt.robot.robot import Robot
from trajopt.server.limits import Limits
from trajopt.server.requests import Done
from trajopt.server.service import OPERATIONS, Service
from trajopt.server.warehouse import Warehouse

Face: TypeAlias = Callable[[Service, asyncio.Event], Awaitable[None]]
"""Serves a started service until an event is set: one protocol on one or several ports."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)


async def run_faces(
    robots: Mapping[str, Robot],
    faces: Sequence[Face],
    *,
    limits: Limits,
    modules: tuple[str, ...] = (OPERATIONS,),
    observer: Callable[[Done], None] | None = None,
    warehouse: Warehouse | None = None,
) -> None:
    """Start a service and its faces, and end them when the process is told to, or a face fails.

    The service ends first: meanwhile its faces refuse new requests, and answer running ones.

    Args:
        robots: The robots by name.
        faces: Its faces.
        limits: Limits of clients.
        modules: Modules with the operations that the faces need.
        observer: Called with each finished request.
        warehouse: Storage of sessions.

    Raises:
        OSError: If a face cannot listen on its address.
        Refusal: If the workers do not start.
    """
    told, stop, loop = asyncio.Event(), asyncio.Event(), asyncio.get_running_loop()
    for each in SIGNALS:
        loop.add_signal_handler(each, told.set)
    try:
        served = Service(robots, limits=limits, modules=modules, observer=observer, warehouse=warehouse)
        async with served as service:
            serving = [asyncio.ensure_future(face(service, stop)) for face in faces]
            waits = (*serving, asyncio.ensure_future(told.wait()))
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
            await service.close(drain=limits.grace)
            stop.set()
            await asyncio.gather(*serving)
    finally:
        for each in SIGNALS:
            loop.remove_signal_handler(each)
