"""Options of the commands that sample a robot: group, frame, count."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from trajopt.cli.options import RobotSource
from trajopt.files.moveit import read_scene
from trajopt.optimise.kinematics.arguments import frame_of
from trajopt.scene.group_tools import end_link
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.errors import ProblemError, shown

GroupOption = Annotated[str, typer.Option("--group", help="Planning group; the only one if left out.")]
FrameOption = Annotated[
    str,
    typer.Option("--frame", help="Link, tool frame or attached object; the group's tip if left out."),
]
CountOption = Annotated[int, typer.Option("--count", min=1, help="How many configurations.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")]
MarginOption = Annotated[float, typer.Option("--margin", min=0.0, help=r"Clearance to keep \[m].")]
SceneOption = Annotated[Path | None, typer.Option("--scene", help="MoveIt PlanningScene in YAML, if any.")]
StateOption = Annotated[
    str | None, typer.Option("--state", help="Named state at which the joints outside the group stand.")
]


def sampled_model(source: RobotSource, scene: Path | None, group: str, state: str | None) -> ReducedModel:
    """Load a robot in its scene with a group's joints free.

    Raises:
        ProblemError: If no group is named and the robot has several.
        NameNotFound: If the group or the state is unknown.
    """
    robot = source.load()
    if not group:
        if len(robot.groups) != 1:
            raise ProblemError(f"name the group with --group: {', '.join(robot.groups)}")
        group = next(iter(robot.groups))
    around = Scene(robot) if scene is None else read_scene(scene, robot).scene
    return reduce_model(around, group, robot.positions(state))


def chosen_frame(reduced: ReducedModel, frame: str) -> str:
    """Return the frame, by default the last link of the group.

    Raises:
        ProblemError: If the group has no single last link.
        FrameNotFound: If there is no such frame.
    """
    tip = frame or end_link(reduced.scene.robot, reduced.group)
    if not tip:
        raise ProblemError(f"group {shown(reduced.group)} has no single end; name the frame with --frame")
    return frame_of(reduced, tip)


def generator(seed: int) -> np.random.Generator:
    """Return the random numbers of a seed."""
    return np.random.default_rng(seed)
