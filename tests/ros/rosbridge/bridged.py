"""A bridge on free ports, and a client that says what it is told to."""

import asyncio
import contextlib
import json
from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

import trajopt as to
from tests.ros.commander.conftest import SRDF, URDF
from trajopt.ros.rosbridge import ANSWERS, RobotDescription, RosbridgeOptions, serve_rosbridge
from trajopt.server import Limits, Service

FEW = Limits(workers=1, waiting=16, grace=0.5, seconds=60.0, body=300_000)
TRIANGLE = (
    b"solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    b"endfacet\nendsolid t\n"
)
"""A mesh file."""


def lab(folder: Path) -> tuple[Path, Path]:
    """Write the files of an arm that is looked at as a mesh of a package; return URDF and SRDF."""
    look = (
        "<visual><geometry><mesh filename='package://lab_description/meshes/look.stl'/></geometry></visual>"
    )
    package = folder / "lab_description"
    (package / "meshes").mkdir(parents=True, exist_ok=True)
    (package / "meshes" / "look.stl").write_bytes(TRIANGLE)
    (package / "secret.txt").write_text("secret")
    (folder / "outside.stl").write_bytes(TRIANGLE)
    urdf, srdf = folder / "lab.urdf", folder / "lab.srdf"
    urdf.write_text(URDF.replace("</inertial>", f"</inertial>{look}", 1))
    srdf.write_text(SRDF)
    return urdf, srdf


class Client:
    """Speaks rosbridge, one operation after the other."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self._count = 0

    async def say(self, **operation: Any) -> None:
        await self.socket.send(json.dumps(operation))

    async def hear(self, **wanted: Any) -> dict[str, Any]:
        """Return the next message that has some members."""
        while True:
            message: dict[str, Any] = json.loads(await asyncio.wait_for(self.socket.recv(), 60.0))
            if all(message.get(key) == value for key, value in wanted.items()):
                return message

    async def ask(self, service: str, args: Any = None, **more: Any) -> dict[str, Any]:
        """Call a service; return the whole response."""
        self._count += 1
        name = f"call:{self._count}"
        await self.say(op="call_service", id=name, service=service, args={} if args is None else args, **more)
        return await self.hear(op="service_response", id=name)

    async def call(self, service: str, args: Any = None, **more: Any) -> Any:
        """Call a service that answers; return what."""
        response = await self.ask(service, args, **more)
        assert response["result"], response["values"]
        return response["values"]


class Bridged:
    """A bridge that listens.

    Attributes:
        port: Of rosbridge.
        mesh_port: Of the meshes.
        service: The service behind it.
    """

    def __init__(self, port: int, mesh_port: int, service: Service) -> None:
        self.port, self.mesh_port, self.service = port, mesh_port, service

    @asynccontextmanager
    async def client(self, **more: Any) -> AsyncGenerator[Client]:
        async with connect(f"ws://127.0.0.1:{self.port}", max_size=None, **more) as socket:
            yield Client(socket)


@asynccontextmanager
async def bridged(folder: Path, limits: Limits = FEW, **stated: Any) -> AsyncGenerator[Bridged]:
    """Serve the arm."""
    urdf, srdf = lab(folder)
    robot = to.load(urdf, srdf=srdf, package_dirs=[folder])
    description = RobotDescription.read(urdf, srdf, [folder])
    options = RosbridgeOptions(port=0, mesh_port=0, **stated)
    async with Service({"lab": robot}, limits=limits, modules=(ANSWERS,)) as service:
        ports: asyncio.Future[tuple[int, int]] = asyncio.get_running_loop().create_future()
        serving = asyncio.create_task(
            serve_rosbridge(
                service, description, options, ready=lambda one, other: ports.set_result((one, other))
            )
        )
        await asyncio.wait({ports, serving}, return_when=asyncio.FIRST_COMPLETED)
        if serving.done():
            serving.result()
        try:
            yield Bridged(*ports.result(), service)
        finally:
            serving.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await serving


def talk(folder: Path, test: Callable[[Client], Awaitable[None]], **stated: Any) -> None:
    """Run a test with one client of a bridge."""

    async def run() -> None:
        async with bridged(folder, **stated) as bridge, bridge.client() as client:
            await test(client)

    asyncio.run(asyncio.wait_for(run(), 200.0))
