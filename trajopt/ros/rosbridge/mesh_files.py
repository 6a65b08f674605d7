"""The meshes of a robot over HTTP, as a file server beside ROS has them: `GET /package/path/to/mesh.stl`."""

import asyncio
from http import HTTPStatus
from urllib.parse import unquote

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from trajopt.ros.rosbridge.description import RobotDescription
from trajopt.ros.rosbridge.options import RosbridgeOptions

TYPES = {
    ".stl": "model/stl",
    ".dae": "model/vnd.collada+xml",
    ".obj": "model/obj",
    ".glb": "model/gltf-binary",
    ".png": "image/png",
    ".jpg": "image/jpeg",
}
OTHER = "application/octet-stream"


def http_response(status: HTTPStatus, body: bytes, kind: str, origin: str = "") -> Response:
    """Return an answer after which the connection is closed.

    Args:
        status: How it went.
        body: What is answered.
        kind: Its media type.
        origin: Where the page is from that may read it.
    """
    headers = Headers()
    headers["Content-Type"] = kind
    headers["Content-Length"] = str(len(body))
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Connection"] = "close"
    if origin:
        headers["Access-Control-Allow-Origin"] = origin
    return Response(status.value, status.phrase, headers, body)


def refusal(status: HTTPStatus, reason: str) -> Response:
    """Return a refusal with its reason."""
    return http_response(status, f"{reason}\n".encode(), "text/plain; charset=utf-8")


def admission_error(options: RosbridgeOptions, headers: Headers) -> Response | None:
    """Return the refusal of a request by its Host and Origin, None if its client is admitted."""
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) > 1 or len(origins) > 1:
        return refusal(HTTPStatus.BAD_REQUEST, "needs one Host and at most one Origin")
    if not options.admits("".join(hosts), "".join(origins)):
        return refusal(HTTPStatus.FORBIDDEN, "this page or this name of the server is not admitted")
    return None


class MeshFiles:
    """Answers requests for the files of a robot's meshes, and for no others."""

    def __init__(self, description: RobotDescription, options: RosbridgeOptions) -> None:
        """Choose the robot."""
        self._description, self._options = description, options

    async def answer(self, connection: ServerConnection, request: Request) -> Response:
        """Answer a request."""
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
