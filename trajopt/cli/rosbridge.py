"""Options of `trajopt serve` for clients made for ROS, and the face that they ask for."""

import asyncio
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Annotated

import typer

from trajopt.cli.options import RobotSource
from trajopt.robot.robot import Robot

if TYPE_CHECKING:
    from trajopt.server import Service
    from trajopt.server.running import Face

PANEL = "Clients made for ROS"


class Ros(Enum):
    """Which ROS is answered as."""

    JAZZY = "jazzy"
    NOETIC = "noetic"


RosbridgePortOption = Annotated[
    int | None,
    typer.Option(
        "--rosbridge-port", help="Port of rosbridge; 0 for any that is free.", rich_help_panel=PANEL
    ),
]
MeshPortOption = Annotated[
    int,
    typer.Option("--mesh-port", help="Port of the robot's meshes over HTTP.", rich_help_panel=PANEL),
]
RosbridgeHostOption = Annotated[
    str,
    typer.Option(
        "--rosbridge-host",
        help="Address of both. Whoever reaches it drives the robot, unless a token is needed.",
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
RosOption = Annotated[Ros, typer.Option("--ros", help="Which ROS is answered as.", rich_help_panel=PANEL)]


@dataclass(frozen=True)
class RosbridgeFace:
    """What serves clients made for ROS, as the options ask for it.

    Attributes:
        host: Address that it listens on.
        port: Of rosbridge.
        mesh_port: Of the meshes.
        origins: Addresses of web pages that may connect.
        ros: Which ROS is answered as.
        clouds: Topics of clouds that become obstacles.
        token: Secret in the address of rosbridge; none is needed if empty.
    """

    host: str
    port: int
    mesh_port: int
    origins: tuple[str, ...]
    ros: Ros
    clouds: tuple[str, ...] = ()
    token: str = ""

    def of(self, source: RobotSource, robot: Robot, names: tuple[str, ...]) -> "Face":
        """Return what serves a robot.

        Args:
            source: Where the robot is from.
            robot: The robot.
            names: Other names by which clients may call this host.

        Raises:
            ModelError: If the robot has no URDF.
        """
        from trajopt.ros.rosbridge import Distro, RobotDescription, RosbridgeOptions, serve_rosbridge

        description = RobotDescription.of(robot, source.srdf, source.package_dirs)
        options = RosbridgeOptions(
            host=self.host,
            port=self.port,
            mesh_port=self.mesh_port,
            origins=self.origins,
            names=names,
            clouds=self.clouds,
            token=self.token,
            distro=Distro[self.ros.name],
        )

        def listening(at: int, meshes: int) -> None:
            shown = f"[{self.host}]" if ":" in self.host else self.host
            typer.echo(f"listening on ws://{shown}:{at} (rosbridge) and http://{shown}:{meshes} (meshes)")

        async def face(service: "Service", stop: asyncio.Event) -> None:
            await serve_rosbridge(service, description, options, ready=listening, stop=stop)

        return face
