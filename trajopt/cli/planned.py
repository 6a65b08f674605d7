"""The problem that a motion in a file belongs to: named by the file itself, or by options."""

from pathlib import Path
from typing import Annotated, cast

import typer

from trajopt.cli.options import RobotSource, read_files
from trajopt.errors import FileFormatError
from trajopt.io.files import read_json
from trajopt.moveit.trajectory_files import FORMATS
from trajopt.problem import Problem, named_problem

MotionArgument = Annotated[Path, typer.Argument(help=f"With --robot ...: {FORMATS}; without: a plan's JSON.")]
OptionalRobot = Annotated[str | None, typer.Option("--robot", help="Robot, where the file does not say it.")]
OptionalScene = Annotated[Path | None, typer.Option("--scene", help="Scene, where the file does not say it.")]
OptionalRequest = Annotated[
    Path | None, typer.Option("--request", help="Request, where the file does not say it.")
]


def problem_of(
    motion: Path, source: RobotSource | None, scene: Path | None, request: Path | None, motions: Path | None
) -> Problem:
    """Return the problem of a motion's file.

    Args:
        motion: The file.
        source: The robot; None where the file, a plan's, says all.
        scene: The scene, with a robot.
        request: The request, with a robot.
        motions: How objects move; with a plan's file instead of what it says.

    Raises:
        FileFormatError: If something is missing, or does not say what it must.
    """
    if source is None:
        return _named_in(motion, motions)
    if scene is None or request is None:
        raise FileFormatError(str(motion), "with --robot give --scene and --request too")
    return read_files(source.load(), scene, request, motions)[1].problem()


def _named_in(plan: Path, motions: Path | None) -> Problem:
    """Rebuild the problem that a plan's file names."""
    document = read_json(plan) if plan.suffix == ".json" else None
    source = cast("dict[str, object]", document).get("source") if isinstance(document, dict) else None
    if not isinstance(source, dict):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    source = cast("dict[str, object]", source)
    if isinstance(source.get("problem"), str):
        if motions is not None:
            raise FileFormatError(str(plan), "is of an installed problem, which takes no --motions")
        return named_problem(str(source["problem"]))
    robot = RobotSource.from_dict(plan, source)
    scene, request = source.get("scene"), source.get("request")
    if not isinstance(scene, str) or not isinstance(request, str):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    own = source.get("motions")
    moving = Path(own) if motions is None and isinstance(own, str) else motions
    return read_files(robot.load(), Path(scene), Path(request), moving)[1].problem()
