"""Serving clients made for ROS until the server is told to end: rosbridge on one port, meshes on another."""

import asyncio
from collections.abc import Callable
from contextlib import AsyncExitStack
from functools import partial
from http import HTTPStatus

from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from trajopt.ros.rosbridge.bridge import Bridge
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.connection import converse
from trajopt.ros.rosbridge.description import RobotDescription
from trajopt.ros.rosbridge.mesh_files import MeshFiles, admission_error, refusal
from trajopt.ros.rosbridge.options import RosbridgeOptions
from trajopt.server.service import Service

ANSWERS = "trajopt.ros.rosbridge.answers"
"""The module of the operations that a service needs for this."""
CLOSING = 1.0
"""Clients are waited for so long when the server ends [s]."""


async def serve_rosbridge(
    service: Service,
    description: RobotDescription,
    options: RosbridgeOptions,
    *,
    robot: str = "",
    ready: Callable[[int, int], None] | None = None,
    stop: asyncio.Event | None = None,
) -> None:
    """Serve until it is cancelled, or told to stop.

    Args:
        service: The service, started, with the operations of `ANSWERS`.
        description: The robot's files.
        options: Where it listens, and whom it lets in.
        robot: Name of the robot; the first one where it is empty.
        ready: Called with the ports of rosbridge and of the meshes, once both listen.
        stop: Set to end.

    Raises:
        OSError: If it cannot listen there.
        RobotNotFound: If there is no such robot.
    """
    cell = Cell(service, robot)
    await service.keep(cell.session)
    bridge = Bridge(cell, description, options)
    meshes = MeshFiles(description, options)

    async def door(connection: ServerConnection, request: Request) -> Response | None:
        not_admitted = admission_error(options, request.headers)
        if not_admitted is not None:
            return not_admitted
        if not options.knows(request.path):
            return refusal(HTTPStatus.UNAUTHORIZED, "connect by ws://HOST:PORT/?token=TOKEN")
        return None

    async def nobody(connection: ServerConnection) -> None:
        """Meet no one: every request for a mesh is answered before it could become a conversation."""

    careful = partial(serve, open_timeout=options.head, close_timeout=CLOSING, server_header=None)
    async with AsyncExitStack() as stack:
        rosbridge = careful(
            partial(converse, bridge),
            options.host,
            options.port,
            process_request=door,
            max_size=bridge.largest,
        )
        files = careful(nobody, options.host, options.mesh_port, process_request=meshes.answer)
        listening = [await stack.enter_async_context(each) for each in (rosbridge, files)]
        ports = [next(iter(each.sockets)).getsockname()[1] for each in listening]
        telling = asyncio.create_task(bridge.tell())
        if ready is not None:
            ready(ports[0], ports[1])
        waits = {telling} if stop is None else {telling, asyncio.create_task(stop.wait())}
        try:
            done, _ = await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
            if telling in done:
                telling.result()
        finally:
            for task in waits:
                task.cancel()
            bridge.close()
