"""`trajopt serve`: a planning server for clients on this machine, or on others that know the token."""

import asyncio
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from trajopt.cli.options import RobotSource, robot_options
from trajopt.robot.robot import Robot
from trajopt.values.errors import MissingExtra, ModelError
from trajopt.viewer.server import LAST_PORT

if TYPE_CHECKING:
    from trajopt.ros.rosbridge import RosbridgeOptions
    from trajopt.server import Service
    from trajopt.server.http import HttpOptions, Metrics
    from trajopt.server.service import Face

PANEL = "Clients made for ROS"


class Ros(Enum):
    """ROS distribution to emulate."""

    JAZZY = "jazzy"
    NOETIC = "noetic"


RosbridgePortOption = Annotated[
    int | None,
    typer.Option(
        "--rosbridge-port",
        max=LAST_PORT,
        help="Port of rosbridge; 0 for any free port.",
        rich_help_panel=PANEL,
    ),
]
MeshPortOption = Annotated[
    int,
    typer.Option(
        "--mesh-port", max=LAST_PORT, help="Port of the robot's meshes over HTTP.", rich_help_panel=PANEL
    ),
]
RosbridgeHostOption = Annotated[
    str,
    typer.Option(
        "--rosbridge-host",
        help="Address of both. Without a token each client that reaches it can drive the robot.",
        rich_help_panel=PANEL,
    ),
]
RosbridgeTokenOption = Annotated[
    str,
    typer.Option(
        "--rosbridge-token",
        help="Secret that clients give in their address: ws://HOST:PORT/?token=SECRET.",
        rich_help_panel=PANEL,
    ),
]
OriginOption = Annotated[
    list[str] | None,
    typer.Option(
        "--rosbridge-origin",
        help="Address of a web page that may connect, such as https://cell.example (repeatable).",
        rich_help_panel=PANEL,
    ),
]
CloudOption = Annotated[
    list[str] | None,
    typer.Option(
        "--rosbridge-cloud",
        help="Topic of PointCloud2 messages that become obstacles, such as /camera/points (repeatable).",
        rich_help_panel=PANEL,
    ),
]
RosOption = Annotated[Ros, typer.Option("--ros", help="ROS distribution to emulate.", rich_help_panel=PANEL)]


def rosbridge_face(source: RobotSource, robot: Robot, options: "RosbridgeOptions") -> "Face":
    """Return the rosbridge server for a robot."""
    from trajopt.ros.rosbridge import RobotDescription, serve_rosbridge

    description = RobotDescription.of(robot, source.srdf, source.package_dirs)

    def listening(at: int, meshes: int) -> None:
        shown = f"[{options.host}]" if ":" in options.host else options.host
        typer.echo(f"listening on ws://{shown}:{at} (rosbridge) and http://{shown}:{meshes} (meshes)")

    async def face(service: "Service", stop: asyncio.Event) -> None:
        await serve_rosbridge(service, description, options, ready=listening, stop=stop)

    return face


OPERATIONS, ROSBRIDGE_OPERATIONS = "trajopt.server.operations", "trajopt.ros.rosbridge.answers"
"""Modules with the operations of workers: for all clients, and for clients made for ROS."""
SESSION_PAGE = "trajopt.viewer.live.page"
"""The module of the 3-D page of a session."""
HostOption = Annotated[str, typer.Option("--host", help="Address to listen on.")]
PortOption = Annotated[int, typer.Option("--port", max=LAST_PORT, help="Port; 0 for any free port.")]
TokenOption = Annotated[
    str,
    typer.Option(
        "--token",
        envvar="TRAJOPT_TOKEN",
        help="Token that clients send as Authorization: Bearer TOKEN; required unless on a loopback address.",
    ),
]
NamesOption = Annotated[
    list[str] | None,
    typer.Option("--name", help="Further host name for clients (repeatable)."),
]
WorkersOption = Annotated[
    int | None, typer.Option("--workers", min=1, help="Number of planning processes; default: one per core.")
]
WaitingOption = Annotated[
    int | None,
    typer.Option(
        "--waiting",
        min=1,
        help="Most waiting requests; others are refused, with a delay before the next try.",
    ),
]
SecondsOption = Annotated[
    float | None, typer.Option("--timeout", metavar="S", help="Time limit of a request \\[s].")
]
MemoryOption = Annotated[
    int | None, typer.Option("--memory", metavar="MB", min=1, help="Memory limit of a request.")
]
WarehouseOption = Annotated[
    Path | None,
    typer.Option("--warehouse", help="File that stores the sessions, for use after a restart."),
]


@robot_options
def serve(
    robot: list[RobotSource],
    host: HostOption = "127.0.0.1",
    port: PortOption = 8080,
    token: TokenOption = "",
    name: NamesOption = None,
    workers: WorkersOption = None,
    waiting: WaitingOption = None,
    timeout: SecondsOption = None,
    memory: MemoryOption = None,
    warehouse: WarehouseOption = None,
    rosbridge_port: RosbridgePortOption = None,
    mesh_port: MeshPortOption = 9190,
    rosbridge_host: RosbridgeHostOption = "127.0.0.1",
    rosbridge_origin: OriginOption = None,
    rosbridge_token: RosbridgeTokenOption = "",
    rosbridge_cloud: CloudOption = None,
    ros: RosOption = Ros.JAZZY,
) -> None:
    """Serve robots over HTTP until Ctrl-C, and, with a rosbridge port, to clients made for ROS.

    See docs/server.md and docs/from-compas-fab.md.
    """
    try:
        from trajopt.server import Limits
        from trajopt.server.http import HttpOptions, Metrics
        from trajopt.server.limits import MEGABYTE
        from trajopt.server.service import log_request, run_faces, write_log
        from trajopt.server.warehouse import Warehouse
    except ModuleNotFoundError as error:
        raise MissingExtra(str(error.name), "server") from error

    robots = loaded(robot)
    megabytes = None if memory is None else memory * MEGABYTE
    most = Limits(**stated(workers=workers, waiting=waiting, seconds=timeout, memory=megabytes))
    options = HttpOptions(host=host, port=port, token=token, names=tuple(name or ()))
    metrics = Metrics()

    def observed(done: Any) -> None:
        metrics.count(done)
        log_request(done)

    faces, modules = [http_face(options, metrics)], [OPERATIONS, SESSION_PAGE]
    if rosbridge_port is not None:
        from trajopt.ros.rosbridge import Distro, RosbridgeOptions

        rosbridge = RosbridgeOptions(
            host=rosbridge_host,
            port=rosbridge_port,
            mesh_port=mesh_port,
            origins=tuple(rosbridge_origin or ()),
            names=options.names,
            clouds=tuple(rosbridge_cloud or ()),
            token=rosbridge_token,
            distro=Distro[ros.name],
        )
        faces.append(rosbridge_face(robot[0], next(iter(robots.values())), rosbridge))
        modules.append(ROSBRIDGE_OPERATIONS)
    write_log()
    kept = None if warehouse is None else Warehouse(warehouse)
    served = run_faces(robots, faces, limits=most, modules=tuple(modules), observer=observed, warehouse=kept)
    try:
        asyncio.run(served)
    except OSError as error:
        raise ModelError(f"cannot listen: {error}") from error


def http_face(options: "HttpOptions", metrics: "Metrics") -> "Face":
    """Return the HTTP server."""
    from trajopt.server.http import serve_http

    def listening(at: int) -> None:
        shown = f"[{options.host}]" if ":" in options.host else options.host
        typer.echo(f"listening on http://{shown}:{at}")

    async def face(service: "Service", stop: asyncio.Event) -> None:
        metrics.of(service)
        await serve_http(service, options, metrics=metrics, ready=listening, stop=stop)

    return face


def stated(**limits: float | None) -> dict[str, Any]:
    return {key: value for key, value in limits.items() if value is not None}


def loaded(sources: list[RobotSource]) -> dict[str, Robot]:
    robots: dict[str, Robot] = {}
    for source in sources:
        robot = source.load()
        name = robot.name if Path(source.robot).is_file() else source.robot
        if name in robots:
            raise ModelError(f"two robots are named {name!r}")
        robots[name] = robot
    return robots
