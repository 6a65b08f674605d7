"""`trajopt serve`: a planning server for clients on this machine, or on others that know the token."""

import asyncio
from pathlib import Path
from typing import Annotated, Any

import typer

from trajopt.cli.options import (
    ExactOption,
    JerkOption,
    LimitsOption,
    PackageOption,
    RobotSource,
    SrdfOption,
    TorqueOption,
)
from trajopt.errors import MissingExtra, ModelError
from trajopt.model.robot import Robot

RobotsOption = Annotated[
    list[str],
    typer.Option("--robot", help="Installed robot, or a URDF, xacro or MJCF file (repeatable)."),
]
HostOption = Annotated[str, typer.Option("--host", help="Address to listen on.")]
PortOption = Annotated[int, typer.Option("--port", help="Port; 0 for any that is free.")]
TokenOption = Annotated[
    str,
    typer.Option(
        "--token",
        envvar="TRAJOPT_TOKEN",
        help="What clients must send as Authorization: Bearer TOKEN; needed on any but a loopback address.",
    ),
]
NamesOption = Annotated[
    list[str] | None,
    typer.Option("--name", help="Another name by which clients may call this host (repeatable)."),
]
WorkersOption = Annotated[
    int | None, typer.Option("--workers", min=1, help="Processes that plan; as many as cores by default.")
]
WaitingOption = Annotated[
    int | None, typer.Option("--waiting", min=1, help="Requests that may wait; more are told to come again.")
]
SecondsOption = Annotated[
    float | None, typer.Option("--timeout", metavar="S", help="Time that one request may take.")
]
MemoryOption = Annotated[
    int | None, typer.Option("--memory", metavar="MB", min=1, help="Memory that one request may take.")
]


def serve(
    robot: RobotsOption,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    exact_meshes: ExactOption = False,
    torque_scaling: TorqueOption = 1.0,
    limit_jerk: JerkOption = False,
    host: HostOption = "127.0.0.1",
    port: PortOption = 8080,
    token: TokenOption = "",
    name: NamesOption = None,
    workers: WorkersOption = None,
    waiting: WaitingOption = None,
    timeout: SecondsOption = None,
    memory: MemoryOption = None,
) -> None:
    """Serve robots over HTTP until Ctrl-C. docs/server.md says what can be asked."""
    try:
        from trajopt.server import Limits
        from trajopt.server.http import HttpOptions, Metrics, serve_http
        from trajopt.server.limits import MEGABYTE
        from trajopt.server.log import log_request, write_log
        from trajopt.server.running import run_faces
    except ModuleNotFoundError as error:
        raise MissingExtra(str(error.name), "server") from error

    folders = tuple(package_dir or ())
    beside = (srdf, limits, folders, exact_meshes, torque_scaling, limit_jerk)
    robots = loaded([RobotSource(each, *beside) for each in robot])
    stated: dict[str, Any] = {
        "workers": workers,
        "waiting": waiting,
        "seconds": timeout,
        "memory": None if memory is None else memory * MEGABYTE,
    }
    most = Limits(**{key: value for key, value in stated.items() if value is not None})
    options = HttpOptions(host=host, port=port, token=token, names=tuple(name or ()))
    metrics = Metrics()

    def listening(at: int) -> None:
        shown = f"[{host}]" if ":" in host else host
        typer.echo(f"listening on http://{shown}:{at}")

    async def face(service: Any, stop: asyncio.Event) -> None:
        metrics.of(service)
        await serve_http(service, options, metrics=metrics, ready=listening, stop=stop)

    def observed(done: Any) -> None:
        metrics.count(done)
        log_request(done)

    write_log()
    try:
        asyncio.run(run_faces(robots, [face], limits=most, observer=observed))
    except OSError as error:
        raise ModelError(f"cannot listen on {host}:{port}: {error.strerror}") from error


def loaded(sources: list[RobotSource]) -> dict[str, Robot]:
    """Return robots by the names by which clients know them: an installed one's, or that of the description.

    Raises:
        ModelError: If two have the same name.
    """
    robots: dict[str, Robot] = {}
    for source in sources:
        robot = source.load()
        name = robot.name if Path(source.robot).is_file() else source.robot
        if name in robots:
            raise ModelError(f"two robots are named {name!r}")
        robots[name] = robot
    return robots
