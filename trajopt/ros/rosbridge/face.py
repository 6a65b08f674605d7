"""Serving clients made for ROS: rosbridge on one port, the robot's meshes over HTTP on another."""

import asyncio
from collections.abc import Callable
from contextlib import AsyncExitStack
from functools import partial
from http import HTTPStatus
from urllib.parse import unquote

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from trajopt.ros.rosbridge.bridge import Bridge
from trajopt.ros.rosbridge.cell import Cell
from trajopt.ros.rosbridge.connection import converse
from trajopt.ros.rosbridge.description import RobotDescription
from trajopt.ros.rosbridge.options import RosbridgeOptions
from trajopt.server.service import Service

TYPES = {
    ".stl": "model/stl",
    ".dae": "model/vnd.collada+xml",
    ".obj": "model/obj",
    ".glb": "model/gltf-binary",
    ".png": "image/png",
    ".jpg": "image/jpeg",
}
OTHER = "application/octet-stream"
ANSWERS = "trajopt.ros.rosbridge.answers"
CLOSING = 1.0
"""Time to wait for clients when the server ends [s]."""


def http_response(status: HTTPStatus, body: bytes, kind: str, origin: str = "") -> Response:
    headers = Headers()
    headers["Content-Type"] = kind
    headers["Content-Length"] = str(len(body))
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Connection"] = "close"
    if origin:
        headers["Access-Control-Allow-Origin"] = origin
    return Response(status.value, status.phrase, headers, body)


def refusal(status: HTTPStatus, reason: str) -> Response:
    return http_response(status, f"{reason}\n".encode(), "text/plain; charset=utf-8")


def admission_error(options: RosbridgeOptions, headers: Headers) -> Response | None:
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) > 1 or len(origins) > 1:
        return refusal(HTTPStatus.BAD_REQUEST, "needs one Host and at most one Origin")
    if not options.admits("".join(hosts), "".join(origins)):
        return refusal(HTTPStatus.FORBIDDEN, "this page or this name of the server is not admitted")
    return None


class MeshFiles:
    """Answers requests for the files of a robot's meshes, and for no others."""

    def __init__(self, description: RobotDescription, options: RosbridgeOptions) -> None:
        self._description, self._options = description, options

    async def answer(self, connection: ServerConnection, request: Request) -> Response:
        not_admitted = admission_error(self._options, request.headers)
        if not_admitted is not None:
            return not_admitted
        name = unquote(request.path.partition("?")[0]).removeprefix("/")
        found = await asyncio.to_thread(self._description.file, name)
        if found is None:
            return refusal(HTTPStatus.NOT_FOUND, "no file of the robot's packages has that name")
        body = await asyncio.to_thread(found.read_bytes)
        return http_response(
            HTTPStatus.OK, body, TYPES.get(found.suffix.lower(), OTHER), request.headers.get("Origin", "")
        )


async def serve_rosbridge(
    service: Service,
    description: RobotDescription,
    options: RosbridgeOptions,
    *,
    robot: str = "",
    ready: Callable[[int, int], None] | None = None,
    stop: asyncio.Event | None = None,
) -> None:
    """Serve until cancelled or stopped.

    Args:
        ready: Called with the ports of rosbridge and of the meshes, once both listen.

    Raises:
        OSError: If the address cannot be listened on.
        RobotNotFound: If the robot does not exist.
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
        """Do nothing; mesh requests are answered before the WebSocket handshake."""

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
