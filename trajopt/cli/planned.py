"""Motions in files, and the problems that they belong to: named by the file itself, or by options."""

import atexit
from functools import cache
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Annotated, cast

import typer

from trajopt.cli.ends import Ends, scene_around
from trajopt.cli.options import RobotSource, read_files
from trajopt.files.bundle import Bundle, read_bundle
from trajopt.files.bundle.bundle import SUFFIX
from trajopt.files.moveit.trajectory_files import FORMATS, read_trajectory
from trajopt.problem.problem import Problem, named_problem
from trajopt.values.documents.files import read_json
from trajopt.values.errors import FileFormatError
from trajopt.values.trajectory import Trajectory

MotionArgument = Annotated[
    Path, typer.Argument(help=f"With --robot ...: {FORMATS}; without: a bundle, or a plan's JSON.")
]
OptionalRobot = Annotated[str | None, typer.Option("--robot", help="Robot, where the file does not say it.")]
OptionalScene = Annotated[Path | None, typer.Option("--scene", help="Scene, where the file does not say it.")]
OptionalRequest = Annotated[
    Path | None, typer.Option("--request", help="Request, where the file does not say it.")
]


def is_bundle(path: Path) -> bool:
    """Return whether a file is a bundle, by its name."""
    return path.suffix.lower() == SUFFIX


@cache
def bundle_in(path: Path) -> Bundle:
    """Return a bundle, its meshes unpacked to a folder that is removed at the end of the process.

    Raises:
        FileFormatError: If the file is invalid.
    """
    folder = mkdtemp(prefix="trajopt-")
    atexit.register(rmtree, folder, ignore_errors=True)
    return read_bundle(path, meshes=folder)


def motion_in(path: Path) -> Trajectory:
    """Return the motion in a file: a bundle, or any format of `read_trajectory`.

    Raises:
        FileFormatError: If the file is invalid.
        ModelError: If it is a bundle without a motion.
    """
    return bundle_in(path).require() if is_bundle(path) else read_trajectory(path)


def problem_of(
    motion: Path, source: RobotSource | None, scene: Path | None, request: Path | None, motions: Path | None
) -> Problem:
    """Return the problem of a motion's file.

    Args:
        motion: The file.
        source: The robot; None if the file, a bundle or a plan's, contains everything.
        scene: The scene, with a robot.
        request: The request, with a robot.
        motions: Motions of objects; for a plan's file instead of its own.

    Raises:
        FileFormatError: If something is missing or invalid.
    """
    if is_bundle(motion):
        if source is not None or motions is not None:
            raise FileFormatError(str(motion), "says all itself: leave out --robot and --motions")
        return bundle_in(motion).problem
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
    if ends := Ends.from_dict(source):
        moving = motions or (Path(str(source["motions"])) if "motions" in source else None)
        around, _ = scene_around(robot, Path(scene) if isinstance(scene, str) else None, moving)
        return ends.problem(around)
    if not isinstance(scene, str) or not isinstance(request, str):
        raise FileFormatError(str(plan), "names no scene; give --robot, --scene and --request")
    own = source.get("motions")
    moving = Path(own) if motions is None and isinstance(own, str) else motions
    return read_files(robot.load(), Path(scene), Path(request), moving)[1].problem()
